// SPDX-License-Identifier: Apache-2.0
#include "server/state/survey_desk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>

#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

v1::SurveyReply reply_of(SurveyDesk::Outcome outcome, const FoundSurface& found) {
  using Outcome = SurveyDesk::Outcome;
  v1::SurveyReply reply;
  switch (outcome) {
    case Outcome::kNoVolume:
      reply.mutable_refused()->set_message("there is no volume yet, expected one to look at");
      break;
    case Outcome::kNoMemory:
      reply.mutable_refused()->set_message("the server has no memory left to look for the surface");
      break;
    case Outcome::kBusy:
      reply.mutable_refused()->set_message(kRendererBusySentence);
      break;
    case Outcome::kNoSurface:
      reply.mutable_refused()->set_message(
          "no surface stands out of this volume; its slices (mode slices) show more");
      break;
    case Outcome::kFound:
      *reply.mutable_found()->mutable_scene() = scene_message(found.scene);
      for (const std::string& choice : found.choices) reply.mutable_found()->add_choices(choice);
      reply.mutable_found()->set_unsure(!found.is_sure);
      break;
  }
  return reply;
}

}  // namespace

Result<void> SurveyDesk::request(std::uint64_t asker) {
  thread_owner_.check();
  if (!dependencies_.find) return Error{ErrorCode::kUnavailable, "this server finds no surfaces"};
  if (requests_.size() >= kMostRequests) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} displays wait for the surface, expected a later request", kMostRequests)};
  }
  requests_.push_back({.asker = asker});
  try {
    if (looking_ || begin(dependencies_.scene_in_force())) return {};
  } catch (const std::bad_alloc&) {
    requests_.pop_back();
    throw;
  }
  requests_.pop_back();
  return Error{ErrorCode::kUnavailable, kRendererBusySentence};
}

bool SurveyDesk::look(const Scene& scene) {
  if (!dependencies_.find || looking_) return false;
  requests_.push_back({.asker = kServer});
  try {
    if (begin(scene)) return true;
  } catch (const std::bad_alloc&) {
    // As if too many orders waited: the caller tries again later.
  }
  requests_.pop_back();
  return false;
}

/// Begins a survey for all that wait. False: the renderer has too many orders.
bool SurveyDesk::begin(const Scene& scene) {
  looking_ = dependencies_.volumes.copy(
      EncoderLane::kAsked, copy_, [this, scene](VolumeCopier::Copy copy) { copied(std::move(copy), scene); });
  for (Request& request : requests_) request.is_looked_for = looking_;
  return looking_;
}

void SurveyDesk::copied(VolumeCopier::Copy copy, const Scene& scene) {
  thread_owner_.check();
  copy_ = copy.volume;
  if (copy.outcome == VolumeCopier::Outcome::kNoVolume) return end(Outcome::kNoVolume, {});
  if (copy.outcome == VolumeCopier::Outcome::kBusy) return end(Outcome::kBusy, {});
  if (copy.outcome == VolumeCopier::Outcome::kNoMemory) return end(Outcome::kNoMemory, {});
  struct Survey {
    Outcome outcome = Outcome::kNoSurface;
    FoundSurface found;
  };
  try {
    const auto survey = std::make_shared<Survey>();
    dependencies_.executor(
        EncoderLane::kAsked,
        [survey, scene, volume = std::move(copy.volume), find = dependencies_.find,
         stop = stop_.get_token()] {
          try {
            if (auto found = find(*volume, scene, stop)) *survey = {Outcome::kFound, *std::move(found)};
          } catch (const std::bad_alloc&) {
            survey->outcome = Outcome::kNoMemory;
          }
        },
        [this, survey] { end(survey->outcome, survey->found); });
  } catch (const std::bad_alloc&) {
    end(Outcome::kNoMemory, {});  // nothing was handed over
  }
}

void SurveyDesk::end(Outcome outcome, const FoundSurface& found) {
  answer_all(outcome, found);
  looking_ = false;
  if (requests_.empty()) return copy_.reset();
  try {
    if (begin(dependencies_.scene_in_force())) return;
    outcome = Outcome::kBusy;
  } catch (const std::bad_alloc&) {
    outcome = Outcome::kNoMemory;
  }
  for (Request& request : requests_) request.is_looked_for = true;
  answer_all(outcome, {});
}

/// Answers those whose survey has ended. Where memory runs out for one answer, the others are still given.
void SurveyDesk::answer_all(Outcome outcome, const FoundSurface& found) {
  const auto is_answered = [](const Request& request) { return request.is_looked_for; };
  for (auto next = std::ranges::find_if(requests_, is_answered); next != requests_.end();
       next = std::ranges::find_if(requests_, is_answered)) {
    const std::uint64_t asker = next->asker;
    requests_.erase(next);
    try {
      dependencies_.answered({.asker = asker, .outcome = outcome, .reply = reply_of(outcome, found)});
    } catch (const std::bad_alloc&) {
      // Its session has marked itself, and leaves with the next second.
    }
  }
}

}  // namespace fanlight
