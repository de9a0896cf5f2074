// SPDX-License-Identifier: Apache-2.0
#include "server/state/volume_copier.hpp"

#include <algorithm>
#include <new>

namespace fanlight {

bool VolumeCopier::copy(EncoderLane lane, std::shared_ptr<Volume>& into, Done done) {
  pending_.push_back({.number = last_number_ + 1, .lane = lane, .done = std::move(done)});
  if (!link_.send(VolumeOrder{.number = last_number_ + 1, .into = into})) {
    pending_.pop_back();
    return false;
  }
  ++last_number_;
  into.reset();
  return true;
}

void VolumeCopier::answered(VolumeAnswer answer) {
  const auto found = std::ranges::find(pending_, answer.number, &Pending::number);
  if (found == pending_.end()) return;
  Pending pending = std::move(*found);
  pending_.erase(found);
  switch (answer.outcome) {
    case VolumeAnswer::Outcome::kNoVolume:
      return pending.done({.outcome = Outcome::kNoVolume, .volume = std::move(answer.into)});
    case VolumeAnswer::Outcome::kTooSmall:
      answer.into.reset();  // before the larger memory
      return make_room(answer, std::move(pending));
    case VolumeAnswer::Outcome::kCopied:
      return pending.done({.outcome = Outcome::kCopied, .volume = std::move(answer.into)});
  }
}

/// The render thread must not wait for the system's memory: the pages are in use before it gets them.
void VolumeCopier::make_room(const VolumeAnswer& answer, Pending pending) {
  std::shared_ptr<Pending> kept;
  try {
    const auto made = std::make_shared<std::shared_ptr<Volume>>();
    kept = std::make_shared<Pending>(std::move(pending));
    executor_(
        kept->lane,
        [made, geometry = answer.geometry, frames = answer.frames] {
          try {
            auto volume = std::make_shared<Volume>(geometry, frames);
            volume->use_pages();
            *made = std::move(volume);
          } catch (const std::bad_alloc&) {
            // It stays null.
          }
        },
        [this, made, kept] {
          if (*made == nullptr) return kept->done({.outcome = Outcome::kNoMemory, .volume = nullptr});
          if (!copy(kept->lane, *made, kept->done))
            kept->done({.outcome = Outcome::kBusy, .volume = std::move(*made)});
        });
  } catch (const std::bad_alloc&) {
    // Nothing was handed over.
    (kept != nullptr ? *kept : pending).done({.outcome = Outcome::kNoMemory, .volume = nullptr});
  }
}

}  // namespace fanlight
