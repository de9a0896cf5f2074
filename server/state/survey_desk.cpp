// SPDX-License-Identifier: Apache-2.0
#include "server/state/survey_desk.hpp"

#include <fmt/format.h>

#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

/// What the render thread has found.
v1::SurveyReply reply_of(const SurveyResult& result) {
  v1::SurveyReply reply;
  switch (result.outcome) {
    case SurveyResult::Outcome::kNoVolume:
      reply.mutable_refused()->set_message("there is no volume yet, expected one to look at");
      break;
    case SurveyResult::Outcome::kNoMemory:
      reply.mutable_refused()->set_message("the server has no memory left to look for the surface");
      break;
    case SurveyResult::Outcome::kNoSurface:
      reply.mutable_refused()->set_message(
          "no surface stands out of this volume; its slices (mode slices) show more");
      break;
    case SurveyResult::Outcome::kFound:
      *reply.mutable_found()->mutable_scene() = scene_message(result.scene);
      for (const std::string& choice : result.choices) reply.mutable_found()->add_choices(choice);
      break;
  }
  return reply;
}

}  // namespace

Result<void> SurveyDesk::wish(std::uint64_t asker, const Scene& scene) {
  if (orders_ == nullptr || results_ == nullptr)
    return Error{ErrorCode::kUnavailable, "this server finds no surfaces"};
  if (wishes_.size() >= kMostWishes) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} displays wait for the surface, expected some patience", kMostWishes)};
  }
  wishes_.push_back({.asker = asker});
  if (!looking_) order(scene);
  return {};
}

bool SurveyDesk::look(const Scene& scene) {
  if (orders_ == nullptr || results_ == nullptr || looking_) return false;
  wishes_.push_back({.asker = kServer});
  order(scene);
  return true;
}

void SurveyDesk::order(const Scene& scene) {
  looking_ = true;
  ++ordered_;
  for (Wish& wish : wishes_) wish.order = ordered_;
  orders_->draft() = {.number = ordered_, .scene = scene};
  orders_->publish();
}

std::vector<SurveyDesk::Answer> SurveyDesk::answers(const Scene& scene) {
  std::vector<Answer> all;
  const SurveyResult* const result = results_ == nullptr ? nullptr : results_->newest();
  if (result == nullptr || result->number != ordered_) return all;
  looking_ = false;
  for (const Wish& wish : wishes_) {
    if (wish.order == ordered_)
      all.push_back({.asker = wish.asker, .outcome = result->outcome, .reply = reply_of(*result)});
  }
  std::erase_if(wishes_, [&](const Wish& wish) { return wish.order == ordered_; });
  if (!wishes_.empty()) order(scene);
  return all;
}

}  // namespace fanlight
