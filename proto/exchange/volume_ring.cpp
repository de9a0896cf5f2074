// SPDX-License-Identifier: Apache-2.0
#include "proto/exchange/volume_ring.hpp"

#include <algorithm>
#include <iterator>

namespace fanlight {

VolumeRing::VolumeRing(const Config& config, const Dependencies& dependencies)
    : policy_(config.policy),
      most_kept_(config.kept),
      dependencies_(dependencies),
      slots_(config.slots + config.kept) {
  kept_.reserve(config.kept);
  kept_slots_.reserve(config.kept);
  for (Slot& slot : slots_) {
    slot.volume =
        std::make_unique<Volume>(config.geometry, config.frame_capacity, config.largest_frame_bytes);
  }
}

Volume* VolumeRing::begin() {
  if (writing_ != kNone) return slots_[writing_].volume.get();
  if (policy_ == RingPolicy::kProcessAll && too_many_wait()) return nullptr;
  for (;;) {
    if (take_free()) return slots_[writing_].volume.get();
    if (policy_ == RingPolicy::kProcessAll) return nullptr;

    std::uint64_t seen = 0;
    const std::uint32_t oldest = oldest_published(seen);
    if (oldest == kNone) continue;  // the reader took or freed it between the load and the exchange
    if (slots_[oldest].state.compare_exchange_strong(seen, seen - kPublished + kFree,
                                                     std::memory_order_acq_rel)) {
      counters_.volumes_dropped.add();
    }
  }
}

/// Whether as many volumes as without keep() are read or wait to be.
bool VolumeRing::too_many_wait() const {
  const auto in_use = std::ranges::count_if(slots_, [](const Slot& slot) {
    const State state = state_of(slot.state.load(std::memory_order_acquire));
    return state == kPublished || state == kReading;
  });
  return in_use >= std::ssize(slots_) - std::ptrdiff_t{most_kept_};
}

bool VolumeRing::take_free() {
  for (;;) {
    std::uint64_t seen = 0;
    const std::uint32_t oldest_free = oldest(kFree, seen);
    if (oldest_free == kNone) return false;
    Slot& slot = slots_[oldest_free];
    // Fails where the reader keeps the volume meanwhile.
    if (!slot.state.compare_exchange_strong(seen, word(kWriting, 0), std::memory_order_acq_rel)) continue;
    writing_ = oldest_free;
    slot.volume->clear();
    return true;
  }
}

void VolumeRing::publish() {
  Slot& slot = slots_[writing_];
  writing_ = kNone;
  slot.volume->stamp().volume_id = ++last_id_;
  counters_.volumes_published.add();
  const auto commit_numbers = slot.volume->commit_numbers();
  slot.commit_number.store(commit_numbers.empty() ? 0 : *std::ranges::max_element(commit_numbers),
                           std::memory_order_relaxed);
  slot.state.store(word(kPublished, last_id_), std::memory_order_release);
  dependencies_.reader_bell.ring();
}

void VolumeRing::abandon() {
  slots_[writing_].state.store(word(kFree, 0), std::memory_order_release);
  writing_ = kNone;
}

std::uint32_t VolumeRing::oldest(State state, std::uint64_t& seen) const {
  std::uint32_t oldest = kNone;
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    const std::uint64_t now = slots_[index].state.load(std::memory_order_acquire);
    // The state bits of these words are equal, so the comparison orders them by id.
    if (state_of(now) == state && (oldest == kNone || now < seen)) {
      oldest = index;
      seen = now;
    }
  }
  return oldest;
}

/// Of the volumes in free slots whose word is less than `below`.
std::uint32_t VolumeRing::newest_free(std::uint64_t below, std::uint64_t& seen) const {
  std::uint32_t newest = kNone;
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    const std::uint64_t now = slots_[index].state.load(std::memory_order_acquire);
    if (state_of(now) != kFree || now == word(kFree, 0) || now >= below) continue;
    if (newest == kNone || now > seen) {
      newest = index;
      seen = now;
    }
  }
  return newest;
}

std::span<const Volume* const> VolumeRing::keep() {
  release_kept();
  std::uint64_t below = ~std::uint64_t{0};
  while (kept_.size() < most_kept_) {
    std::uint64_t seen = 0;
    const std::uint32_t newest = newest_free(below, seen);
    if (newest == kNone) break;
    below = seen;
    if (!slots_[newest].state.compare_exchange_strong(seen, seen - kFree + kKept, std::memory_order_acq_rel))
      continue;  // the writer has just taken it
    kept_.push_back(slots_[newest].volume.get());
    kept_slots_.push_back(newest);
  }
  std::ranges::reverse(kept_);
  return kept_;
}

void VolumeRing::release_kept() {
  for (const std::uint32_t slot : kept_slots_) release(slot);
  kept_slots_.clear();
  kept_.clear();
}

VolumeRing::Lease VolumeRing::take() {
  std::uint32_t held = kNone;
  for (;;) {
    std::uint64_t seen = 0;
    const std::uint32_t oldest = oldest_published(seen);
    if (oldest == kNone) break;
    const std::uint64_t reading = seen - kPublished + kReading;
    if (!slots_[oldest].state.compare_exchange_strong(seen, reading, std::memory_order_acq_rel)) continue;
    if (held != kNone) {
      counters_.volumes_dropped.add();
      release(held);
    }
    held = oldest;
    if (policy_ == RingPolicy::kProcessAll) break;
  }
  if (held == kNone) return {};
  counters_.volumes_taken.add();
  return {*this, held};
}

std::optional<std::uint64_t> VolumeRing::waiting_commit_number() const {
  // The writer may take a slot meanwhile, for a volume with larger numbers.
  std::optional<std::uint64_t> number;
  std::uint64_t chosen = 0;
  for (const Slot& slot : slots_) {
    const std::uint64_t now = slot.state.load(std::memory_order_acquire);
    if (state_of(now) != kPublished) continue;
    const bool earlier = now < chosen;
    if (number && earlier != (policy_ == RingPolicy::kProcessAll)) continue;
    chosen = now;
    number = slot.commit_number.load(std::memory_order_relaxed);
  }
  return number;
}

bool VolumeRing::has_published() const {
  std::uint64_t seen = 0;
  return oldest_published(seen) != kNone;
}

void VolumeRing::release(std::uint32_t slot) {
  // Only the reader changes a slot that it reads or keeps.
  const std::uint64_t id = slots_[slot].state.load(std::memory_order_relaxed) >> kStateBits;
  slots_[slot].state.store(word(kFree, id), std::memory_order_release);
  dependencies_.writer_bell.ring();
}

std::uint64_t VolumeRing::capacity_bytes() const {
  std::uint64_t bytes = 0;
  for (const Slot& slot : slots_) bytes += slot.volume->capacity_bytes();
  return bytes;
}

}  // namespace fanlight
