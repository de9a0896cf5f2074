// SPDX-License-Identifier: Apache-2.0
#include "proto/exchange/frame_queue.hpp"

#include <algorithm>

namespace fanlight {

FrameQueue::FrameQueue(const Config& config, const Dependencies& dependencies)
    : largest_frame_bytes_(config.largest_frame_bytes),
      dependencies_(dependencies),
      // Not make_unique: it would write every page before the first frame.
      pixels_(new std::uint8_t[config.largest_frame_bytes * config.slots]),
      slots_(config.slots) {}

bool FrameQueue::put(const FrameStamp& stamp, const FanGeometry& geometry,
                     std::span<const std::uint8_t> pixels) {
  const std::uint64_t number = put_.load(std::memory_order_relaxed);  // only this thread writes it
  const bool full = number - popped_.load(std::memory_order_acquire) == slots_.size();
  if (full || pixels.size() > largest_frame_bytes_) {
    counters_.frames_not_fed.add();
    return false;
  }
  const std::uint64_t slot = number % slots_.size();
  std::uint8_t* const copy = pixels_.get() + largest_frame_bytes_ * slot;
  std::ranges::copy(pixels, copy);
  slots_[slot] = {.stamp = stamp, .geometry = geometry, .pixels = {copy, pixels.size()}};
  counters_.frames_fed.add();
  put_.store(number + 1, std::memory_order_release);
  dependencies_.reader_bell.ring();
  return true;
}

const QueuedFrame* FrameQueue::front() const {
  const std::uint64_t number = popped_.load(std::memory_order_relaxed);  // only this thread writes it
  if (number == put_.load(std::memory_order_acquire)) return nullptr;
  return &slots_[number % slots_.size()];
}

void FrameQueue::pop() {
  popped_.fetch_add(1, std::memory_order_release);
}

}  // namespace fanlight
