// SPDX-License-Identifier: Apache-2.0
// When the acquisition thread starts, and what a device that is refused leaves. No device is opened.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "acquisition/source/pacer.hpp"
#include "proto/base/clock.hpp"
#include "server/pipeline/pipeline.hpp"

namespace fanlight {
namespace {

/// Frames without end, one a millisecond.
class CountedSource final : public FrameSource {
 public:
  CountedSource(bool waits, std::uint64_t volumes) : waits_(waits) {
    description_.geometry = {
        .columns = 4, .rows = 4, .pixel_width_mm = 1, .pixel_height_mm = 1, .motor_radius_mm = 30};
    description_.frames_per_volume = 2;
    description_.last_angle_rad = 0.01;
    description_.volumes = volumes;
  }

  const SourceDescription& description() const override { return description_; }
  bool waits() const override { return waits_; }

  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override {
    pacer_.wait_until(now_ns() + 1'000'000, stop);
    if (stop.stop_requested()) return std::optional<FrameStamp>{};
    const std::uint64_t number = frames_.fetch_add(1);
    FrameStamp stamp;
    stamp.sequence = number;
    stamp.volume_index = number / 2;
    stamp.frame_index = static_cast<std::uint32_t>(number % 2);
    stamp.angle_rad = 0.01 * static_cast<double>(number % 2);
    return std::optional(stamp);
  }

  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token /*stop*/) override {
    std::ranges::fill(pixels, std::uint8_t{1});
    return FrameFault::kNone;
  }

  std::uint64_t frames() const { return frames_; }
  /// Waits for a frame that comes after the call; false where none comes for so long.
  bool delivers(std::chrono::milliseconds longest) const {
    const std::uint64_t before = frames();
    const auto latest = std::chrono::steady_clock::now() + longest;
    while (frames() == before && std::chrono::steady_clock::now() < latest)
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    return frames() > before;
  }

 private:
  bool waits_;
  std::atomic<std::uint64_t> frames_ = 0;
  Pacer pacer_;
  SourceDescription description_;
};

struct Refused {
  bool delivered_meanwhile = false;
  Error error;
};

constexpr std::chrono::milliseconds kLong{10'000};
constexpr std::chrono::milliseconds kShort{50};

/// A pipeline whose device is refused as soon as a frame has come, or after `longest`.
Refused refused_pipeline(CountedSource& source, bool acquires_early, std::chrono::milliseconds longest) {
  SourceLink link;
  Refused refused;
  const auto refuse = [&](const std::string& /*name*/) -> Result<RenderDevice> {
    refused.delivered_meanwhile = source.delivers(longest);
    return Error{ErrorCode::kNotFound, "there is no device"};
  };
  auto pipeline = Pipeline::create({.size = {.width = 8, .height = 8}, .acquires_early = acquires_early},
                                   {.open_device = refuse, .source = source, .link = link});
  EXPECT_FALSE(pipeline);
  if (!pipeline) refused.error = pipeline.error();
  return refused;
}

TEST(PipelineStartTest, ALiveSourceDeliversWhileTheDeviceIsOpened) {
  CountedSource source(false, 0);
  const Refused refused = refused_pipeline(source, true, kLong);
  EXPECT_TRUE(refused.delivered_meanwhile);
  EXPECT_EQ(refused.error.message, "there is no device");
  EXPECT_FALSE(source.delivers(kShort)) << "its thread has not ended";
}

// They would lose their first frames.
TEST(PipelineStartTest, OtherSourcesWaitForTheDevice) {
  CountedSource waits(true, 0);
  EXPECT_FALSE(refused_pipeline(waits, true, kShort).delivered_meanwhile);
  CountedSource ends(false, 3);
  EXPECT_FALSE(refused_pipeline(ends, true, kShort).delivered_meanwhile);
  CountedSource unasked(false, 0);
  EXPECT_FALSE(refused_pipeline(unasked, false, kShort).delivered_meanwhile);
  EXPECT_EQ(waits.frames() + ends.frames() + unasked.frames(), 0U);
}

}  // namespace
}  // namespace fanlight
