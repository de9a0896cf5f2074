// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "acquisition/record/recorder.hpp"
#include "acquisition/record/recover_recording.hpp"
#include "acquisition/replay/recording.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {

/// A recorder of a source with small frames that the test plays, in a folder of its own.
class RecorderTest : public testing::Test {
 protected:
  static constexpr std::uint32_t kColumns = 6;
  static constexpr std::uint32_t kRows = 4;
  static constexpr std::int64_t kFrameNs = 10'000'000;
  static constexpr std::uint32_t kFramesInSweep = 5;

  static FanGeometry geometry(std::uint32_t rows = kRows) {
    return {.columns = kColumns,
            .rows = rows,
            .pixel_width_mm = 0.3,
            .pixel_height_mm = 1.0 / 3,
            .face_column = 2.5,
            .face_row = -0.5,
            .motor_radius_mm = 28,
            .probe_radius_mm = 40};
  }

  RecorderTest() {
    source_.name = "phantom:";
    source_.geometry = geometry();
    source_.largest_frame_bytes = 1000;
    source_.frames_per_volume = kFramesInSweep;
    source_.first_angle_rad = -0.3;
    source_.last_angle_rad = 0.3;
  }

  /// Frame `i` of a probe that sweeps to and fro; its pixels are all of one value.
  static FrameStamp stamp(std::uint64_t i) {
    const auto in_sweep = static_cast<std::uint32_t>(i % kFramesInSweep);
    const bool backward = i / kFramesInSweep % 2 == 1;
    const double share = static_cast<double>(backward ? kFramesInSweep - 1 - in_sweep : in_sweep);
    return {.sequence = 100 + i,
            .volume_index = 7 + i / kFramesInSweep,
            .frame_index = in_sweep,
            .frames_in_sweep = kFramesInSweep,
            .direction = backward ? SweepDirection::kBackward : SweepDirection::kForward,
            .angle_rad = 0.1 * share / 3 - 0.05,
            .capture_time_ns = 5'000'000'123 + static_cast<std::int64_t>(i) * kFrameNs};
  }
  static std::vector<std::uint8_t> pixels(std::uint64_t i, std::uint32_t rows = kRows) {
    return std::vector<std::uint8_t>(kColumns * rows, static_cast<std::uint8_t>(i + 1));
  }

  void begin(const RecordingOrder& order) { tell(order, RecordingOrder::Wish::kRecord); }
  void finish() { tell({}, RecordingOrder::Wish::kEnd); }

  /// Gives an order, and waits until it is taken.
  void tell(RecordingOrder order, RecordingOrder::Wish wish) {
    if (!recorder_) recorder_ = std::make_unique<Recorder>(source_, bell_);
    order.number = ++orders_;
    order.wish = wish;
    ASSERT_TRUE(recorder_->link().send(order));
    wait_for([this] { return status_.order_done == orders_; });
  }

  /// As the acquisition thread, which waits for no one; here it waits for room.
  void put(const FrameStamp& stamp, const FanGeometry& of, std::span<const std::uint8_t> pixels,
           FrameFault fault = FrameFault::kNone) {
    FrameQueue& queue = recorder_->tap().queue();
    while (queue.is_full()) std::this_thread::yield();
    if (fault == FrameFault::kNone) {
      ASSERT_TRUE(queue.put(stamp, of, pixels));
    } else {
      ASSERT_TRUE(queue.put_fault(stamp, of, fault));
    }
  }
  void put(std::uint64_t i) { put(stamp(i), geometry(), pixels(i)); }

  void wait_for(const std::function<bool()>& reached) {
    while (!reached()) {
      bell_.wait(1'000'000'000);
      if (const RecordingStatus* newest = recorder_->link().status.newest()) status_ = *newest;
    }
  }
  void wait_for_state(RecordingStatus::State state) {
    wait_for([this, state] { return status_.state == state; });
  }

  /// Writes all final files and ends the recorder.
  void end() {
    recorder_->end(Recorder::Finish::kWait);
    if (const RecordingStatus* newest = recorder_->link().status.newest()) status_ = *newest;
    recorder_.reset();
  }

  static Recording open(const std::filesystem::path& path) {
    auto recording = Recording::open({.path = path, .geometry_path = {}});
    if (!recording) {
      ADD_FAILURE() << recording.error().message;
      std::abort();
    }
    return *std::move(recording);
  }

  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      names.insert(entry.path().filename().string());
    return names;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "sweeps.igs.mha";
  SourceDescription source_;
  Doorbell bell_;
  RecordingStatus status_;
  std::uint64_t orders_ = 0;
  std::unique_ptr<Recorder> recorder_;
};

}  // namespace fanlight::test
