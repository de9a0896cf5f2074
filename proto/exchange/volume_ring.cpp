// SPDX-License-Identifier: Apache-2.0
#include "proto/exchange/volume_ring.hpp"

namespace fanlight {

VolumeRing::VolumeRing(const Config& config, const Dependencies& dependencies)
    : policy_(config.policy), dependencies_(dependencies), slots_(config.slots) {
  for (Slot& slot : slots_) {
    slot.volume =
        std::make_unique<Volume>(config.geometry, config.frame_capacity, config.largest_frame_bytes);
  }
}

Volume* VolumeRing::begin() {
  if (writing_ != kNone) return slots_[writing_].volume.get();
  for (;;) {
    for (std::uint32_t index = 0; index < slots_.size(); ++index) {
      // Only the writer takes a free slot, so a plain store is sufficient once it is seen free.
      if (state_of(slots_[index].state.load(std::memory_order_acquire)) != kFree) continue;
      slots_[index].state.store(word(kWriting, 0), std::memory_order_relaxed);
      writing_ = index;
      slots_[index].volume->clear();
      return slots_[index].volume.get();
    }
    if (policy_ == RingPolicy::kProcessAll) return nullptr;

    std::uint64_t seen = 0;
    const std::uint32_t oldest = oldest_published(seen);
    if (oldest == kNone) continue;  // the reader took or freed it between the load and the exchange
    if (slots_[oldest].state.compare_exchange_strong(seen, word(kFree, 0), std::memory_order_acq_rel)) {
      counters_.volumes_dropped.add();
    }
  }
}

void VolumeRing::publish() {
  Slot& slot = slots_[writing_];
  writing_ = kNone;
  slot.volume->stamp().volume_id = ++last_id_;
  counters_.volumes_published.add();
  slot.state.store(word(kPublished, last_id_), std::memory_order_release);
  dependencies_.reader_bell.ring();
}

void VolumeRing::abandon() {
  slots_[writing_].state.store(word(kFree, 0), std::memory_order_release);
  writing_ = kNone;
}

std::uint32_t VolumeRing::oldest_published(std::uint64_t& seen) const {
  std::uint32_t oldest = kNone;
  for (std::uint32_t index = 0; index < slots_.size(); ++index) {
    const std::uint64_t now = slots_[index].state.load(std::memory_order_acquire);
    // The state bits of published words are equal, so the comparison orders them by id.
    if (state_of(now) == kPublished && (oldest == kNone || now < seen)) {
      oldest = index;
      seen = now;
    }
  }
  return oldest;
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

bool VolumeRing::has_published() const {
  std::uint64_t seen = 0;
  return oldest_published(seen) != kNone;
}

void VolumeRing::release(std::uint32_t slot) {
  slots_[slot].state.store(word(kFree, 0), std::memory_order_release);
  dependencies_.writer_bell.ring();
}

std::uint64_t VolumeRing::capacity_bytes() const {
  std::uint64_t bytes = 0;
  for (const Slot& slot : slots_) bytes += slot.volume->capacity_bytes();
  return bytes;
}

}  // namespace fanlight
