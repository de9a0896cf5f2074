// SPDX-License-Identifier: Apache-2.0
#include "server/state/fluid_desk.hpp"

#include <fmt/format.h>

#include <cmath>
#include <new>

namespace fanlight {

namespace {

constexpr double kMostMm = 10'000;
constexpr double kMostShiftDb = 12;
constexpr const char* kNoMemorySentence = "the server has no memory left to measure fluid";

Result<void> check(const FluidQuestion& question) {
  for (const double mm : {question.at.x_mm, question.at.y_mm, question.at.z_mm}) {
    if (!(std::abs(mm) <= kMostMm)) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("the point lies at {} mm, expected at most {} mm to either side", mm, kMostMm)};
    }
  }
  if (!(std::abs(question.border_db) <= kMostShiftDb)) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("border_db is {}, expected -{} to {}",
                                                          question.border_db, kMostShiftDb, kMostShiftDb)};
  }
  return {};
}

v1::FluidReply refusal(const std::string& sentence) {
  v1::FluidReply reply;
  reply.mutable_refused()->set_message(sentence);
  return reply;
}

}  // namespace

Result<void> FluidDesk::request(std::uint64_t asker, const FluidQuestion& question) {
  thread_owner_.check();
  if (!dependencies_.measure) return Error{ErrorCode::kUnavailable, "this server measures no fluid"};
  if (auto good = check(question); !good) return good;
  if (requests_.size() >= kMostRequests) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} measurements of fluid wait, expected a later request", kMostRequests)};
  }
  requests_.push_back({.asker = asker, .question = question});
  try {
    if (is_busy_ || begin()) return {};
  } catch (const std::bad_alloc&) {
    requests_.pop_back();
    throw;
  }
  requests_.pop_back();
  return Error{ErrorCode::kUnavailable, kRendererBusySentence};
}

/// Begins what waits first. False: the renderer has too many orders.
bool FluidDesk::begin() {
  is_busy_ = dependencies_.volumes.copy(EncoderLane::kBackground, copy_,
                                        [this](VolumeCopier::Copy copy) { copied(std::move(copy)); });
  return is_busy_;
}

void FluidDesk::copied(VolumeCopier::Copy copy) {
  thread_owner_.check();
  copy_ = std::move(copy.volume);
  switch (copy.outcome) {
    case VolumeCopier::Outcome::kNoVolume:
      return refuse("there is no volume yet, expected one that is shown");
    case VolumeCopier::Outcome::kNoMemory:
      return refuse(kNoMemorySentence);
    case VolumeCopier::Outcome::kBusy:
      return refuse(kRendererBusySentence);
    case VolumeCopier::Outcome::kCopied:
      break;
  }
  if (copy_->stamp().volume_id != requests_.front().question.volume_id)
    return refuse("another volume is shown by now, expected a point of the one on show; freeze it first");
  try {
    measure(copy_);
  } catch (const std::bad_alloc&) {
    refuse(kNoMemorySentence);  // nothing was handed over
  }
}

void FluidDesk::measure(std::shared_ptr<Volume> volume) {
  const auto reply = std::make_shared<v1::FluidReply>();
  dependencies_.executor(
      EncoderLane::kBackground,
      [reply, volume = std::move(volume), question = requests_.front().question,
       measure = dependencies_.measure, stop = stop_.get_token()] {
        try {
          auto region = measure(*volume, question, stop);
          if (!region) {
            *reply = refusal(region.error().message);
            return;
          }
          region->set_volume_id(question.volume_id);
          *reply->mutable_found() = *std::move(region);
        } catch (const std::bad_alloc&) {
          reply->Clear();  // refused below, on the server thread
        }
      },
      [this, reply] {
        if (reply->outcome_case() == v1::FluidReply::OUTCOME_NOT_SET) return refuse(kNoMemorySentence);
        end(std::move(*reply));
      });
}

void FluidDesk::refuse(const char* sentence) {
  end(refusal(sentence));
}

/// Answers what is under way, and begins the next; what cannot be begun is answered too.
void FluidDesk::end(v1::FluidReply reply) {
  answer_first(std::move(reply));
  is_busy_ = false;
  while (!requests_.empty()) {
    const char* refused = kRendererBusySentence;
    try {
      if (begin()) return;
    } catch (const std::bad_alloc&) {
      refused = kNoMemorySentence;
    }
    answer_first(refusal(refused));
  }
  copy_.reset();
}

/// Where memory runs out for the answer, its session has marked itself, and leaves with the next second.
void FluidDesk::answer_first(v1::FluidReply reply) {
  const std::uint64_t asker = requests_.front().asker;
  requests_.pop_front();
  try {
    dependencies_.answered({.asker = asker, .reply = std::move(reply)});
  } catch (const std::bad_alloc&) {
    // As said above.
  }
}

}  // namespace fanlight
