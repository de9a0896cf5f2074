// SPDX-License-Identifier: Apache-2.0
#include "proto/exchange/volume_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>
#include <thread>
#include <vector>

namespace fanlight {
namespace {

FanGeometry small_geometry() {
  FanGeometry geometry;
  geometry.columns = 16;
  geometry.rows = 8;
  geometry.pixel_width_mm = 1;
  geometry.pixel_height_mm = 1;
  geometry.motor_radius_mm = 30;
  return geometry;
}

class VolumeRingTest : public testing::Test {
 protected:
  static constexpr std::uint32_t kSlots = 4;

  VolumeRing make(RingPolicy policy) {
    return VolumeRing({.geometry = small_geometry(), .frame_capacity = 3, .slots = kSlots, .policy = policy},
                      {.reader_bell = reader_bell_, .writer_bell = writer_bell_});
  }

  /// Fills a volume so that every byte and stamp contains `mark`, and publishes it.
  static void publish(VolumeRing& ring, std::uint64_t mark) {
    Volume* const volume = ring.begin();
    ASSERT_NE(volume, nullptr);
    while (!volume->full()) {
      std::ranges::fill(volume->next_frame_pixels(), static_cast<std::uint8_t>(mark));
      volume->add_frame({.sequence = mark,
                         .volume_index = mark,
                         .frame_index = volume->stamp().frames,
                         .frames_in_sweep = 3,
                         .direction = SweepDirection::kForward,
                         .angle_rad = 0.1 * volume->stamp().frames,
                         .capture_time_ns = 0});
    }
    volume->sort_by_angle();
    ring.publish();
  }

  static void expect_whole(const Volume& volume) {
    const std::uint64_t mark = volume.stamp().source_volume_index;
    ASSERT_EQ(volume.stamp().frames, 3U);
    ASSERT_EQ(volume.stamp().last_frame_sequence, mark);
    for (std::uint32_t frame = 0; frame < 3; ++frame) {
      for (const std::uint8_t pixel : volume.frame_pixels(frame)) {
        ASSERT_EQ(pixel, static_cast<std::uint8_t>(mark)) << "a torn volume";
      }
    }
  }

  Doorbell reader_bell_;
  Doorbell writer_bell_;
};

TEST_F(VolumeRingTest, GivesNothingBeforeTheFirstVolume) {
  VolumeRing ring = make(RingPolicy::kNewestWins);
  EXPECT_FALSE(ring.has_published());
  EXPECT_FALSE(ring.take());
  EXPECT_EQ(ring.capacity_bytes(), kSlots * 3U * 16U * 8U);
}

TEST_F(VolumeRingTest, BeginIsTheSameVolumeUntilItIsPublishedOrAbandoned) {
  VolumeRing ring = make(RingPolicy::kNewestWins);
  Volume* const volume = ring.begin();
  EXPECT_EQ(ring.begin(), volume);
  ring.abandon();
  EXPECT_FALSE(ring.has_published());
  EXPECT_EQ(ring.counters().volumes_published.value(), 0U);
}

TEST_F(VolumeRingTest, NewestWinsDropsTheOlderAndCountsThem) {
  VolumeRing ring = make(RingPolicy::kNewestWins);
  for (std::uint64_t mark = 1; mark <= 10; ++mark) publish(ring, mark);
  EXPECT_TRUE(reader_bell_.wait(0));
  {
    const auto lease = ring.take();
    ASSERT_TRUE(lease);
    EXPECT_EQ(lease->stamp().source_volume_index, 10U);
    EXPECT_EQ(lease->stamp().volume_id, 10U);
    EXPECT_FALSE(ring.take()) << "an older volume after a newer one";
  }
  EXPECT_TRUE(writer_bell_.wait(0));
  EXPECT_EQ(ring.counters().volumes_published.value(), 10U);
  EXPECT_EQ(ring.counters().volumes_taken.value(), 1U);
  EXPECT_EQ(ring.counters().volumes_dropped.value(), 9U);
}

/// Two volumes whose frames have the commit numbers 10 to 12 and 20 to 22.
void publish_two(VolumeRing& ring) {
  for (const std::uint64_t first : {10U, 20U}) {
    Volume* const volume = ring.begin();
    for (const std::uint64_t later : {2U, 0U, 1U}) {
      volume->next_frame_pixels();
      volume->add_frame({.sequence = later, .commit_number = first + later});
    }
    ring.publish();
  }
}

TEST_F(VolumeRingTest, HasTheCommitNumberOfTheVolumeThatIsTakenNext) {
  VolumeRing newest = make(RingPolicy::kNewestWins);
  EXPECT_EQ(newest.waiting_commit_number(), std::nullopt);
  publish_two(newest);
  EXPECT_EQ(newest.waiting_commit_number(), 22U);
  { const auto lease = newest.take(); }
  EXPECT_EQ(newest.waiting_commit_number(), std::nullopt);

  VolumeRing all = make(RingPolicy::kProcessAll);
  publish_two(all);
  EXPECT_EQ(all.waiting_commit_number(), 12U);
  { const auto lease = all.take(); }
  EXPECT_EQ(all.waiting_commit_number(), 22U);
}

TEST_F(VolumeRingTest, NewestWinsNeverTakesBackWhatIsBeingRead) {
  VolumeRing ring = make(RingPolicy::kNewestWins);
  publish(ring, 1);
  const auto lease = ring.take();
  for (std::uint64_t mark = 2; mark <= 20; ++mark) publish(ring, mark);
  ASSERT_TRUE(lease);
  EXPECT_EQ(lease->stamp().source_volume_index, 1U);
  expect_whole(*lease);
}

TEST_F(VolumeRingTest, ProcessAllKeepsTheOrderAndMakesTheWriterWait) {
  VolumeRing ring = make(RingPolicy::kProcessAll);
  for (std::uint64_t mark = 1; mark <= kSlots; ++mark) publish(ring, mark);
  EXPECT_EQ(ring.begin(), nullptr);
  EXPECT_EQ(ring.take()->stamp().source_volume_index, 1U);
  EXPECT_NE(ring.begin(), nullptr) << "the slot of the lease that just ended";
  for (std::uint64_t mark = 2; mark <= kSlots; ++mark) {
    EXPECT_EQ(ring.take()->stamp().source_volume_index, mark);
  }
  EXPECT_EQ(ring.counters().volumes_dropped.value(), 0U);
}

TEST_F(VolumeRingTest, AMovedLeaseReleasesItsSlotOnce) {
  VolumeRing ring = make(RingPolicy::kProcessAll);
  publish(ring, 1);
  VolumeRing::Lease kept;
  {
    VolumeRing::Lease taken = ring.take();
    kept = std::move(taken);
  }
  EXPECT_FALSE(writer_bell_.wait(0));
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->stamp().source_volume_index, 1U);
  kept = {};
  EXPECT_TRUE(writer_bell_.wait(0));
}

std::vector<std::uint64_t> marks(std::span<const Volume* const> volumes) {
  std::vector<std::uint64_t> marks;
  for (const Volume* const volume : volumes) marks.push_back(volume->stamp().source_volume_index);
  return marks;
}

TEST_F(VolumeRingTest, KeepsTheLastVolumesWhileFurtherOnesCome) {
  VolumeRing ring({.geometry = small_geometry(), .frame_capacity = 3, .slots = kSlots, .kept = 5},
                  {.reader_bell = reader_bell_, .writer_bell = writer_bell_});
  EXPECT_TRUE(ring.keep().empty()) << "a slot that never held a volume";
  VolumeRing::Lease shown;
  for (std::uint64_t mark = 1; mark <= 20; ++mark) {
    publish(ring, mark);
    if (mark % 2 == 1) continue;  // skipped by the reader
    shown = {};
    shown = ring.take();
  }
  const std::vector<std::uint64_t> expected = {15, 16, 17, 18, 19};
  EXPECT_EQ(marks(ring.keep()), expected);
  const std::uint64_t dropped = ring.counters().volumes_dropped.value();
  for (std::uint64_t mark = 21; mark <= 40; ++mark) publish(ring, mark);
  EXPECT_EQ(marks(ring.kept()), expected);
  for (const Volume* const volume : ring.kept()) expect_whole(*volume);
  EXPECT_EQ(shown->stamp().source_volume_index, 20U);
  EXPECT_EQ(ring.counters().volumes_dropped.value() - dropped, 20U - (kSlots - 1));
  ring.release_kept();
  shown = {};
  EXPECT_EQ(ring.take()->stamp().source_volume_index, 40U);
  for (std::uint64_t mark = 41; mark <= 60; ++mark) publish(ring, mark);
  EXPECT_EQ(ring.take()->stamp().source_volume_index, 60U);
}

TEST_F(VolumeRingTest, LetsNoMoreVolumesWaitBecauseOfThoseItMayKeep) {
  VolumeRing ring({.geometry = small_geometry(),
                   .frame_capacity = 3,
                   .slots = kSlots,
                   .kept = 5,
                   .policy = RingPolicy::kProcessAll},
                  {.reader_bell = reader_bell_, .writer_bell = writer_bell_});
  for (std::uint64_t mark = 1; mark <= kSlots; ++mark) publish(ring, mark);
  EXPECT_EQ(ring.begin(), nullptr);
  for (std::uint64_t mark = 5; mark <= 12; ++mark) {
    EXPECT_EQ(ring.take()->stamp().source_volume_index, mark - 4);
    publish(ring, mark);
  }
  EXPECT_EQ(marks(ring.keep()), (std::vector<std::uint64_t>{4, 5, 6, 7, 8}));
  EXPECT_EQ(ring.begin(), nullptr);
}

TEST_F(VolumeRingTest, KeepsNoVolumeThatWasGivenUp) {
  VolumeRing ring({.geometry = small_geometry(), .frame_capacity = 3, .slots = 3, .kept = 2},
                  {.reader_bell = reader_bell_, .writer_bell = writer_bell_});
  publish(ring, 1);
  ring.begin();
  ring.abandon();
  ring.take();
  EXPECT_EQ(marks(ring.keep()), std::vector<std::uint64_t>{1});
}

// Run with the thread sanitizer: the reader keeps and lets go while the writer takes free slots.
TEST_F(VolumeRingTest, TwoThreadsWhileVolumesAreKept) {
  VolumeRing ring({.geometry = small_geometry(), .frame_capacity = 3, .slots = kSlots, .kept = 4},
                  {.reader_bell = reader_bell_, .writer_bell = writer_bell_});
  constexpr std::uint64_t kVolumes = 20'000;
  std::jthread writer([&ring] {
    for (std::uint64_t mark = 1; mark <= kVolumes; ++mark) publish(ring, mark);
  });
  for (std::uint64_t last = 0; last < kVolumes;) {
    if (const auto lease = ring.take()) last = lease->stamp().source_volume_index;
    std::uint64_t before = 0;
    for (const Volume* const volume : ring.keep()) {
      expect_whole(*volume);
      EXPECT_GT(volume->stamp().volume_id, before);
      before = volume->stamp().volume_id;
    }
    ring.release_kept();
  }
}

// Run with the thread sanitizer. The reader ends with the last volume, which neither policy may drop.
TEST_F(VolumeRingTest, TwoThreadsNewestWins) {
  constexpr std::uint64_t kVolumes = 20'000;
  VolumeRing ring = make(RingPolicy::kNewestWins);
  std::jthread writer([&ring] {
    for (std::uint64_t mark = 1; mark <= kVolumes; ++mark) publish(ring, mark);
  });
  std::uint64_t last = 0;
  std::uint64_t taken = 0;
  while (last < kVolumes) {
    reader_bell_.wait(-1);
    const auto lease = ring.take();
    if (!lease) continue;
    ASSERT_GT(lease->stamp().volume_id, last);
    last = lease->stamp().volume_id;
    expect_whole(*lease);
    ++taken;
  }
  writer.join();
  EXPECT_FALSE(ring.has_published());
  EXPECT_EQ(ring.counters().volumes_published.value(), kVolumes);
  EXPECT_EQ(ring.counters().volumes_taken.value(), taken);
  EXPECT_EQ(ring.counters().volumes_taken.value() + ring.counters().volumes_dropped.value(), kVolumes);
}

TEST_F(VolumeRingTest, TwoThreadsProcessAll) {
  constexpr std::uint64_t kVolumes = 5'000;
  VolumeRing ring = make(RingPolicy::kProcessAll);
  std::jthread writer([&] {
    for (std::uint64_t mark = 1; mark <= kVolumes; ++mark) {
      while (ring.begin() == nullptr) writer_bell_.wait(-1);
      publish(ring, mark);
    }
  });
  std::uint64_t last = 0;
  while (last < kVolumes) {
    reader_bell_.wait(-1);
    while (const auto lease = ring.take()) {
      ASSERT_EQ(lease->stamp().volume_id, last + 1);
      ++last;
      expect_whole(*lease);
    }
  }
  writer.join();
  EXPECT_EQ(ring.counters().volumes_taken.value(), kVolumes);
  EXPECT_EQ(ring.counters().volumes_dropped.value(), 0U);
}

}  // namespace
}  // namespace fanlight
