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

bool FrameQueue::is_full() const {
  // Only this thread writes put_.
  const std::uint64_t number = put_.load(std::memory_order_relaxed);
  return number - popped_.load(std::memory_order_acquire) == slots_.size();
}

bool FrameQueue::has_room() {
  const bool room = !is_full();
  if (!room) counters_.frames_not_fed.add();
  return room;
}

void FrameQueue::publish(const QueuedFrame& frame) {
  const std::uint64_t number = put_.load(std::memory_order_relaxed);
  slots_[number % slots_.size()] = frame;
  counters_.frames_fed.add();
  put_.store(number + 1, std::memory_order_release);
  dependencies_.reader_bell.ring();
}

bool FrameQueue::put(const FrameStamp& stamp, const FanGeometry& geometry,
                     std::span<const std::uint8_t> pixels) {
  const std::span<std::uint8_t> copy = reserve(pixels.size());
  if (copy.empty()) return false;
  std::ranges::copy(pixels, copy.begin());
  commit(stamp, geometry);
  return true;
}

std::span<std::uint8_t> FrameQueue::reserve(std::uint64_t bytes) {
  if (bytes > largest_frame_bytes_) {
    counters_.frames_not_fed.add();
    return {};
  }
  if (!has_room()) return {};
  const std::uint64_t number = put_.load(std::memory_order_relaxed);
  if (number == popped_.load(std::memory_order_acquire)) first_slot_number_ = number;
  // Those in the queue have consecutive numbers, so no two of them share a slot.
  const std::uint64_t slot = (number - first_slot_number_) % slots_.size();
  reserved_ = {pixels_.get() + largest_frame_bytes_ * slot, bytes};
  return reserved_;
}

void FrameQueue::commit(const FrameStamp& stamp, const FanGeometry& geometry) {
  publish({.stamp = stamp, .geometry = geometry, .pixels = reserved_});
}

bool FrameQueue::put_fault(const FrameStamp& stamp, const FanGeometry& geometry, FrameFault fault) {
  if (!has_room()) return false;
  publish({.stamp = stamp, .geometry = geometry, .pixels = {}, .fault = fault});
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
