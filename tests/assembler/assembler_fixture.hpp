// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <stop_token>

#include "acquisition/assembly/assembler.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

inline FanGeometry small_geometry() {
  return {.columns = 4, .rows = 3, .pixel_width_mm = 1, .pixel_height_mm = 1, .motor_radius_mm = 30};
}

inline std::uint64_t sum_of_fates(const AcquisitionCounters& counters) {
  std::uint64_t sum = counters.frames_pending.value();
  for (const Counter* counter :
       {&counters.frames_assembled, &counters.frames_invalid, &counters.frames_damaged, &counters.frames_cut,
        &counters.frames_misfit, &counters.frames_repeated, &counters.frames_late,
        &counters.frames_over_capacity, &counters.frames_in_short_volumes,
        &counters.frames_in_incomplete_volumes, &counters.frames_abandoned}) {
    sum += counter->value();
  }
  return sum;
}

/// An assembler with its ring and its queue, and hand-made frames of a source that sweeps forward and
/// backward, 2 deg a frame.
class AssemblerTest : public testing::Test {
 protected:
  struct Set {
    RingPolicy policy = RingPolicy::kNewestWins;
    std::uint32_t capacity = 5;
    Assembler::Config config = {};
    std::uint32_t queue_slots = 8;
  };

  AssemblerTest() : AssemblerTest(Set{}) {}
  explicit AssemblerTest(const Set& set)
      : ring_({.geometry = small_geometry(), .frame_capacity = set.capacity, .policy = set.policy},
              {.reader_bell = reader_bell_, .writer_bell = writer_bell_}),
        queue_({.largest_frame_bytes = small_geometry().frame_bytes(), .slots = set.queue_slots},
               {.reader_bell = reader_bell_}),
        assembler_({.ring = ring_,
                    .writer_bell = writer_bell_,
                    .counters = counters_,
                    .frame_queue = &queue_,
                    .dropped = &dropped_},
                   set.config) {}

  /// The source's next frame.
  FrameStamp frame(std::uint64_t volume_index, std::uint32_t frame_index, std::uint32_t frames_in_sweep) {
    const bool backward = volume_index % 2 == 1;
    const double angle_deg = 2.0 * frame_index;
    return {.sequence = sequence_++,
            .volume_index = volume_index,
            .frame_index = frame_index,
            .frames_in_sweep = frames_in_sweep,
            .direction = backward ? SweepDirection::kBackward : SweepDirection::kForward,
            .angle_rad = radians(backward ? 20 - angle_deg : angle_deg),
            .geometry_revision = revision_,
            .capture_time_ns = static_cast<std::int64_t>(1000 * sequence_)};
  }

  /// False where the frame was not placed. Every pixel of a frame is its sequence number.
  bool add(const FrameStamp& stamp) {
    const auto pixels = assembler_.place(stamp, geometry_, stop_.get_token());
    if (pixels.empty()) return false;
    EXPECT_EQ(pixels.size(), geometry_.frame_bytes());
    std::ranges::fill(pixels, static_cast<std::uint8_t>(stamp.sequence));
    assembler_.commit();
    return true;
  }

  void add_sweep(std::uint64_t volume_index, std::uint32_t frames, std::uint32_t announced) {
    for (std::uint32_t i = 0; i < frames; ++i) add(frame(volume_index, i, announced));
  }

  std::uint64_t published() const { return ring_.counters().volumes_published.value(); }

  void expect_identity() const {
    EXPECT_EQ(counters_.frames_received.value(), sum_of_fates(counters_));
    EXPECT_EQ(counters_.frames_pending.value(), assembler_.frames_pending());
  }

  Doorbell reader_bell_;
  Doorbell writer_bell_;
  DroppedSweeps dropped_;
  AcquisitionCounters counters_;
  std::stop_source stop_;
  FanGeometry geometry_ = small_geometry();
  std::uint32_t revision_ = 0;
  VolumeRing ring_;
  FrameQueue queue_;
  Assembler assembler_;
  std::uint64_t sequence_ = 0;
};

}  // namespace fanlight
