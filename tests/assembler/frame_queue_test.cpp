// SPDX-License-Identifier: Apache-2.0
// Frames in the queue ahead of their volume, and their commit numbers in both.
#include <map>
#include <random>
#include <vector>

#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

class Feeding : public AssemblerTest {
 protected:
  explicit Feeding(const Set& set = {.capacity = 20, .queue_slots = 64}) : AssemblerTest(set) {}

  /// Empties the queue; returns the sequence numbers of its frames. Their commit numbers must continue the
  /// earlier ones.
  std::vector<std::uint64_t> take_sequences() {
    std::vector<std::uint64_t> sequences;
    for (; const QueuedFrame* const frame = queue_.front(); queue_.pop()) {
      EXPECT_EQ(frame->stamp.commit_number, ++commit_numbers_);
      EXPECT_EQ(frame->pixels.size(), frame->geometry.frame_bytes());
      const auto pixel = static_cast<std::uint8_t>(frame->stamp.sequence);
      EXPECT_TRUE(std::ranges::count(frame->pixels, pixel) == std::ssize(frame->pixels));
      sequences.push_back(frame->stamp.sequence);
    }
    return sequences;
  }

  std::uint64_t commit_numbers_ = 0;
};

using Numbers = std::vector<std::uint64_t>;

TEST_F(Feeding, AFrameComesAheadOfItsVolumeWithItsNumber) {
  for (std::uint32_t i = 0; i < 3; ++i) {
    add(frame(7, i, 4));
    const QueuedFrame* const queued = queue_.front();
    ASSERT_NE(queued, nullptr);
    EXPECT_EQ(queued->stamp.commit_number, i + 1);
    EXPECT_EQ(queued->stamp.sequence, i);
    EXPECT_EQ(queued->stamp.volume_index, 7U);
    EXPECT_EQ(queued->stamp.frame_index, i);
    EXPECT_EQ(queued->stamp.capture_time_ns, 1000 * (i + 1));
    EXPECT_EQ(queued->geometry, geometry_);
    EXPECT_TRUE(
        std::ranges::equal(queued->pixels, std::vector<std::uint8_t>(12, static_cast<std::uint8_t>(i))));
    queue_.pop();
    EXPECT_EQ(queue_.front(), nullptr) << "once each";
  }
  EXPECT_EQ(published(), 0U);
  add(frame(7, 3, 4));
  EXPECT_EQ(published(), 1U);
  ASSERT_NE(queue_.front(), nullptr) << "the last one too";
  EXPECT_EQ(queue_.front()->stamp.commit_number, 4U);
  EXPECT_TRUE(std::ranges::equal(ring_.take()->commit_numbers(), Numbers{1, 2, 3, 4}));
}

TEST_F(Feeding, NumbersGoOnOverVolumesAndSweepsGivenUp) {
  add_sweep(0, 4, 4);
  EXPECT_TRUE(std::ranges::equal(ring_.take()->commit_numbers(), Numbers{1, 2, 3, 4}));
  add_sweep(1, 3, 4);
  assembler_.abandon();
  add_sweep(2, 4, 4);
  EXPECT_TRUE(std::ranges::equal(ring_.take()->commit_numbers(), Numbers{8, 9, 10, 11}));
  EXPECT_EQ(take_sequences().size(), 11U);
}

TEST_F(Feeding, FramesWithoutAPlaceAreNotFedAndHaveNoNumber) {
  add_sweep(0, 3, 20);
  FrameStamp repeated = frame(0, 2, 20);
  repeated.sequence = --sequence_ - 1;
  EXPECT_FALSE(add(repeated));
  assembler_.reject(frame(0, 3, 20), FrameFault::kDamaged);
  const FrameStamp cut = frame(0, 4, 20);
  ASSERT_FALSE(assembler_.place(cut, geometry_, stop_.get_token()).empty());
  assembler_.reject(cut, FrameFault::kCut);
  FrameStamp unusable = frame(0, 5, 20);
  unusable.angle_rad = kPi;
  EXPECT_FALSE(add(unusable));
  EXPECT_EQ(take_sequences(), (Numbers{0, 1, 2}));
  const FrameStamp late = frame(0, 6, 20);
  add_sweep(1, 2, 2);
  EXPECT_FALSE(add(late));
  EXPECT_FALSE(add(frame(1, 2, 2))) << "one more than announced";
  EXPECT_EQ(take_sequences(), (Numbers{7, 8}));
  EXPECT_EQ(counters_.frames_repeated.value() + counters_.frames_late.value() +
                counters_.frames_over_capacity.value(),
            3U);
}

TEST_F(Feeding, AReorderedFrameIsNumberedAsItCame) {
  add(frame(0, 0, 4));
  const FrameStamp second = frame(0, 1, 4);
  add(frame(0, 2, 4));
  EXPECT_TRUE(add(second));
  add(frame(0, 3, 4));
  EXPECT_EQ(take_sequences(), (Numbers{0, 2, 1, 3}));
  const auto volume = ring_.take();
  EXPECT_TRUE(std::ranges::equal(volume->commit_numbers(), Numbers{1, 2, 3, 4}));
  EXPECT_EQ(volume->commit_numbers()[volume->by_angle()[1]], 3U);
}

TEST_F(Feeding, AFrameIsFedInTheGeometryItHas) {
  add_sweep(0, 20, 20);
  ++revision_;
  geometry_.columns = 3;
  add_sweep(1, 1, 20);
  EXPECT_EQ(take_sequences().size(), 20U + 1) << "nine bytes each, from now on";
  add(frame(1, 1, 20));
  ASSERT_NE(queue_.front(), nullptr);
  EXPECT_EQ(queue_.front()->geometry, geometry_);
}

class FullFeed : public Feeding {
 protected:
  FullFeed() : Feeding({.capacity = 20, .queue_slots = 3}) {}
};

TEST_F(FullFeed, CostsTheVolumeNothing) {
  add_sweep(0, 10, 10);
  ASSERT_EQ(published(), 1U);
  EXPECT_EQ(ring_.take()->commit_numbers().back(), 10U);
  EXPECT_EQ(take_sequences(), (Numbers{0, 1, 2}));
  EXPECT_EQ(queue_.counters().frames_fed.value(), 3U);
  EXPECT_EQ(queue_.counters().frames_not_fed.value(), 7U);
  add(frame(1, 0, 10));
  ASSERT_NE(queue_.front(), nullptr);
  EXPECT_EQ(queue_.front()->stamp.commit_number, 11U) << "numbers count what was not queued as well";
}

class FeedingOverTurns : public Feeding {
 protected:
  FeedingOverTurns()
      : Feeding({.capacity = 48,
                 .config = {.cut = SweepCut::kByTurning, .range = {radians(-30), radians(30)}},
                 .queue_slots = 48}) {}

  void add_angle(double angle_deg) {
    EXPECT_TRUE(add({.sequence = sequence_++, .angle_rad = radians(angle_deg)}));
  }
};

TEST_F(FeedingOverTurns, FramesCarriedOverKeepTheirNumbers) {
  for (int place = -15; place <= 14; ++place) add_angle(2.0 * place);
  EXPECT_EQ(published(), 0U);
  for (int place = 14; published() == 0; --place) add_angle(2.0 * place);
  const std::uint64_t frames_until_the_turn_showed = sequence_;
  EXPECT_GT(frames_until_the_turn_showed, 31U) << "nothing was carried over";
  EXPECT_EQ(take_sequences().size(), frames_until_the_turn_showed);
  {
    const auto first = ring_.take();
    EXPECT_EQ(first->commit_numbers().front(), 1U);
    EXPECT_EQ(first->commit_numbers().back(), 30U);
  }
  for (int i = 0; i < 20; ++i) add_angle(20.0 - 2.0 * i);
  assembler_.end_of_source();
  EXPECT_EQ(take_sequences().size(), 20U) << "those carried over were queued before";
  const auto second = ring_.take();
  ASSERT_EQ(second->stamp().frames, sequence_ - 30);
  for (std::uint32_t i = 0; i < second->stamp().frames; ++i) {
    EXPECT_EQ(second->commit_numbers()[i], 31 + i);
    EXPECT_EQ(second->frame_pixels(i)[0], 30 + i) << "a number with another frame's pixels";
  }
}

TEST_F(FeedingOverTurns, EveryFrameOfAVolumeIsTheOneFedUnderItsNumber) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> jitter(-0.8, 0.8);
  std::map<std::uint64_t, std::uint8_t> queued_pixels;
  std::uint64_t newest = 0;
  std::uint32_t in_volumes = 0;
  for (int i = 0; i < 900; ++i) {
    add_angle(2.0 * std::abs(i % 58 - 29) - 29 + jitter(random));
    const QueuedFrame* const frame = queue_.front();
    ASSERT_NE(frame, nullptr);
    EXPECT_TRUE(queued_pixels.emplace(frame->stamp.commit_number, frame->pixels[0]).second)
        << "a number given twice";
    queue_.pop();
    const auto volume = ring_.take();
    if (!volume) continue;
    for (std::uint32_t k = 0; k < volume->stamp().frames; ++k) {
      const std::uint64_t commit_number = volume->commit_numbers()[k];
      EXPECT_GT(commit_number, std::exchange(newest, commit_number));
      ASSERT_TRUE(queued_pixels.contains(commit_number));
      EXPECT_EQ(volume->frame_pixels(k)[0], queued_pixels[commit_number]);
      ++in_volumes;
    }
  }
  EXPECT_EQ(in_volumes + assembler_.frames_pending(), 900U);
  EXPECT_GT(published(), 25U);
}

}  // namespace
}  // namespace fanlight
