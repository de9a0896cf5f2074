// SPDX-License-Identifier: Apache-2.0
#include "server/state/fluid_desk.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>

namespace fanlight {

namespace {

constexpr double kMostPointMm = 10'000;
// Of the border: kLeastBorderDb and kMostBorderDb of the renderer's fluid_region.hpp.
constexpr double kLeastShiftDb = -12;
constexpr double kMostShiftDb = 3;
constexpr const char* kNoMemorySentence = "the server has no memory left to measure fluid";

Result<void> check(const FluidQuestion& question) {
  for (const double mm : {question.at.x_mm, question.at.y_mm, question.at.z_mm}) {
    if (!(std::abs(mm) <= kMostPointMm)) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("the point lies at {} mm, expected at most {} mm to either side", mm, kMostPointMm)};
    }
  }
  if (!(question.border_db >= kLeastShiftDb && question.border_db <= kMostShiftDb)) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("border_db is {}, expected {} to {}",
                                                          question.border_db, kLeastShiftDb, kMostShiftDb)};
  }
  return {};
}

}  // namespace

Result<void> FluidDesk::request(std::uint64_t asker, const FluidQuestion& question) {
  thread_owner_.check();
  if (!dependencies_.measure) return Error{ErrorCode::kUnavailable, "this server measures no fluid"};
  if (auto good = check(question); !good) return good;
  if (requests_.size() >= kMostRequests) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} measurements of fluid wait, try again in a moment", kMostRequests)};
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
  is_busy_ = dependencies_.volumes.copy(EncoderLane::kAsked, copy_,
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
  if (!requests_.front().is_wanted || is_stopped_) return refuse("");
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
  stop_ = std::stop_source();
  dependencies_.executor(
      EncoderLane::kAsked,
      [reply, volume = std::move(volume), question = requests_.front().question,
       measure = dependencies_.measure, stop = stop_.get_token()] {
        try {
          auto region = measure(*volume, question, stop);
          if (!region) {
            reply->mutable_refused()->set_message(region.error().message);
            return;
          }
          region->set_volume_id(question.volume_id);
          *reply->mutable_found() = *std::move(region);
        } catch (const std::bad_alloc&) {
          reply->Clear();  // refused on the server thread
        }
      },
      [this, reply] {
        const bool is_done = reply->outcome_case() != v1::FluidReply::OUTCOME_NOT_SET;
        end(kNoMemorySentence, is_done ? reply.get() : nullptr);
      });
}

void FluidDesk::forget(std::uint64_t asker) {
  thread_owner_.check();
  const auto found = std::ranges::find(requests_, asker, &Request::asker);
  if (found == requests_.end()) return;
  if (found != requests_.begin()) {
    requests_.erase(found);
  } else {
    found->is_wanted = false;
    stop_.request_stop();
  }
}

void FluidDesk::stop() {
  is_stopped_ = true;
  stop_.request_stop();
}

void FluidDesk::refuse(const char* sentence) {
  end(sentence);
}

/// Answers what is under way, and begins the next; what cannot be begun is answered too. `reply`: null:
/// refused, with the sentence.
void FluidDesk::end(const char* refused, v1::FluidReply* reply) {
  answer_first(refused, reply);
  is_busy_ = false;
  while (!requests_.empty() && !is_stopped_) {
    const char* why = kRendererBusySentence;
    try {
      if (begin()) return;
    } catch (const std::bad_alloc&) {
      why = kNoMemorySentence;
    }
    answer_first(why, nullptr);
  }
  copy_.reset();
}

/// Where memory runs out for the answer, its session has marked itself, and leaves with the next second.
void FluidDesk::answer_first(const char* refused, v1::FluidReply* reply) {
  const Request request = requests_.front();
  requests_.pop_front();
  if (!request.is_wanted) return;
  try {
    Answer answer{.asker = request.asker};
    if (reply != nullptr) {
      answer.reply = std::move(*reply);
    } else {
      answer.reply.mutable_refused()->set_message(refused);
    }
    dependencies_.answered(answer);
  } catch (const std::bad_alloc&) {
    // As said above.
  }
}

}  // namespace fanlight
