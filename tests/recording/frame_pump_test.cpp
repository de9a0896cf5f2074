// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/frame_pump.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace fanlight::test {
namespace {

/// Frames with the given numbers.
class NumberedSource final : public FrameSource {
 public:
  NumberedSource(std::vector<FrameStamp> stamps, std::uint64_t longest_loss)
      : stamps_(std::move(stamps)), longest_loss_(longest_loss) {
    description_.geometry = {.columns = 4, .rows = 4};
  }
  const SourceDescription& description() const override { return description_; }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token /*stop*/) override {
    if (next_ == stamps_.size()) return std::optional<FrameStamp>();
    return std::optional(stamps_[next_++]);
  }
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token /*stop*/) override {
    std::ranges::fill(pixels, std::uint8_t{1});
    return FrameFault::kNone;
  }
  std::uint64_t longest_loss() const override { return longest_loss_; }

 private:
  std::vector<FrameStamp> stamps_;
  std::uint64_t longest_loss_;
  SourceDescription description_;
  std::size_t next_ = 0;
};

std::vector<FrameStamp> stamps_of(const std::vector<std::uint64_t>& sequences) {
  std::vector<FrameStamp> stamps;
  for (const std::uint64_t sequence : sequences) stamps.push_back({.sequence = sequence});
  return stamps;
}

PumpedFrames pumped_of(std::vector<FrameStamp> stamps, std::uint64_t longest_loss) {
  NumberedSource source(std::move(stamps), longest_loss);
  Doorbell bell;
  FrameTap tap(16, bell);
  tap.open(true);
  PumpedFrames pumped;
  EXPECT_TRUE(pump_frames(source, tap, FullQueue::kLoseFrame, {}, pumped));
  return pumped;
}

constexpr std::uint64_t kAny = ~std::uint64_t{0};

TEST(FramePump, CountsTheNumbersThatDidNotCome) {
  EXPECT_EQ(pumped_of(stamps_of({5, 6, 7}), kAny).lost, 0U) << "a source may begin with any number";
  const PumpedFrames pumped = pumped_of(stamps_of({0, 1, 4, 6}), kAny);
  EXPECT_EQ(pumped.frames, 4U);
  EXPECT_EQ(pumped.lost, 3U);
  EXPECT_EQ(pumped.interruptions, 0U);
  EXPECT_EQ(pumped_of({}, kAny).lost, 0U);
}

TEST(FramePump, CountsNoFrameThatCameOutOfOrder) {
  EXPECT_EQ(pumped_of(stamps_of({0, 2, 1, 3}), kAny).lost, 0U);
}

TEST(FramePump, CountsNoLossWhereTheSourceHasGapsOfItsOwn) {
  EXPECT_EQ(pumped_of(stamps_of({0, 9}), 0).lost, 0U);
}

TEST(FramePump, CountsAGapThatIsTooLongAsAnInterruption) {
  const PumpedFrames jumped = pumped_of(stamps_of({0, 2, 66, 67}), 63);
  EXPECT_EQ(jumped.lost, 1U + 63U);
  const PumpedFrames longer = pumped_of(stamps_of({0, 2, 67, 68}), 63);
  EXPECT_EQ(longer.lost, 1U);
  EXPECT_EQ(longer.interruptions, 1U);
}

TEST(FramePump, CountsAProbeThatCameBackAsAnInterruption) {
  const PumpedFrames pumped = pumped_of({{.sequence = 0}, {.sequence = 1, .after_interruption = true}}, kAny);
  EXPECT_EQ(pumped.lost, 0U);
  EXPECT_EQ(pumped.interruptions, 1U);
}

}  // namespace
}  // namespace fanlight::test
