// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "proto/exchange/frame_queue.hpp"

namespace fanlight {

/// Copies of all frames of a source, usable or not, from the acquisition thread to another one: the
/// recorder's, or the server's. While the tap is closed nothing is copied. The constructor reserves address
/// space; its pages are used from the first copy on.
class FrameTap {
 public:
  /// More than a second of frames at 100 MB/s: so long may a disk not take anything.
  static constexpr std::uint64_t kSecondBytes = 160'000'000;

  /// `largest_frame_bytes`: of all geometries of the source. `queue_bytes`: of frames that wait; there is
  /// room for eight in any case.
  FrameTap(std::uint64_t largest_frame_bytes, Doorbell& reader_bell, std::uint64_t queue_bytes = kSecondBytes)
      : slots_(slots_for(largest_frame_bytes, queue_bytes)),
        queue_({.largest_frame_bytes = largest_frame_bytes, .slots = slots_}, {.reader_bell = reader_bell}) {}

  /// Any thread.
  void open(bool open) { open_.store(open, std::memory_order_release); }
  bool is_open() const { return open_.load(std::memory_order_acquire); }

  /// Frames that found no room, because the reader did not read for as long as the queue lasts. Any thread.
  std::uint64_t frames_missed() const { return queue_.counters().frames_not_fed.value(); }

  FrameQueue& queue() { return queue_; }
  /// Capacity of the queue.
  std::uint32_t slots() const { return slots_; }

 private:
  static std::uint32_t slots_for(std::uint64_t frame_bytes, std::uint64_t queue_bytes) {
    return static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(queue_bytes / std::max<std::uint64_t>(frame_bytes, 1), 8, 4096));
  }

  std::atomic<bool> open_{false};
  std::uint32_t slots_;
  FrameQueue queue_;
};

}  // namespace fanlight
