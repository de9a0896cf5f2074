// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/frame_pump.hpp"

#include <chrono>
#include <optional>
#include <span>
#include <thread>

namespace fanlight {

Result<void> pump_frames(FrameSource& source, FrameTap& tap, FullQueue full, const std::stop_token& stop) {
  FrameQueue& queue = tap.queue();
  while (!stop.stop_requested()) {
    const auto next = source.next_frame(stop);
    if (!next) return next.error();
    const std::optional<FrameStamp>& frame = *next;
    if (!frame) return {};
    while (full == FullQueue::kWait && queue.is_full() && !stop.stop_requested())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const FanGeometry& geometry = source.description().geometry;
    FrameFault fault = source.known_fault();
    if (fault == FrameFault::kNone) {
      const std::span<std::uint8_t> pixels = queue.reserve(geometry.frame_bytes());
      if (pixels.empty()) continue;
      fault = source.read_pixels(pixels, stop);
    }
    if (fault == FrameFault::kNone) {
      queue.commit(*frame, geometry);
    } else if (!stop.stop_requested()) {
      queue.put_fault(*frame, geometry, fault);
    }
  }
  return {};
}

}  // namespace fanlight
