// SPDX-License-Identifier: Apache-2.0
// The sum of the counters, for the writing thread and for a concurrent reader.
#include <atomic>
#include <limits>
#include <random>
#include <thread>

#include "tests/assembler/assembler_fixture.hpp"

namespace fanlight {
namespace {

/// Reads the counters until destroyed; the sum must hold with each read.
class Watcher {
 public:
  explicit Watcher(const AcquisitionCounters& counters) : counters_(counters) {
    while (looks_.load() == 0) std::this_thread::yield();
  }
  ~Watcher() {
    thread_.request_stop();
    thread_.join();
    EXPECT_EQ(wrong_.load(), 0U) << "of " << looks_.load() << " looks";
  }

 private:
  void watch(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::uint64_t received = 0;
      std::uint64_t fates = 0;
      counters_.seq_lock.read([&] {
        received = counters_.frames_received.value();
        fates = sum_of_fates(counters_);
      });
      if (received != fates) ++wrong_;
      ++looks_;
    }
  }

  const AcquisitionCounters& counters_;
  std::atomic<std::uint64_t> looks_ = 0;
  std::atomic<std::uint64_t> wrong_ = 0;
  std::jthread thread_{[this](const std::stop_token& stop) { watch(stop); }};
};

class Counting : public AssemblerTest, public testing::WithParamInterface<SweepCut> {
 protected:
  Counting()
      : AssemblerTest(
            {.capacity = 12,
             .config = {.cut = GetParam(), .range = {radians(-20), radians(20)}, .longest_gap_frames = 2}}) {}

  bool chance(unsigned percent) { return random_() % 100 < percent; }

  FrameStamp next_stamp() {
    FrameStamp stamp = frame(volume_index_, index_++, announces_ ? frames_ : 0);
    const bool backward = volume_index_ % 2 == 1;
    stamp.angle_rad = radians((backward ? 20 : -20) + (backward ? -4.0 : 4.0) * (index_ - 1));
    stamp.geometry_revision = revision_;
    if (index_ == frames_) {
      ++volume_index_;
      index_ = 0;
      frames_ = 8 + static_cast<std::uint32_t>(random_() % 6);
      announces_ = chance(50);
      stands_ = chance(3);
    }
    if (stands_) stamp.angle_rad = 0.1;
    return stamp;
  }

  void disturb(FrameStamp& stamp) {
    if (chance(1)) sequence_ += random_() % 4;
    if (random_() % 2000 == 0) {
      sequence_ = random_() % 2 == 0 ? 0 : sequence_ + 3'000'000;
      stamp.sequence = sequence_++;
    }
    if (random_() % 1000 == 0) {
      stamp.after_interruption = true;
      stamp.sequence = sequence_ = 0;
      ++sequence_;
    }
    if (chance(1)) stamp.angle_rad = std::numeric_limits<double>::quiet_NaN();
    if (random_() % 500 == 0) {
      stamp.geometry_revision = ++revision_;
      geometry_.columns = 3 + revision_ % 3;  // 3, 4, or 5 columns; 5 does not fit
    }
  }

  void give(const FrameStamp& stamp) {
    if (chance(1)) {
      constexpr FrameFault kFaults[] = {FrameFault::kInvalid, FrameFault::kDamaged, FrameFault::kCut,
                                        FrameFault::kMisfit};
      const FrameFault fault = kFaults[random_() % 4];
      if (chance(50)) (void)assembler_.place(stamp, geometry_, stop_.get_token());
      assembler_.reject(stamp, fault);
    } else if (chance(1)) {
      (void)assembler_.place(stamp, geometry_, stop_.get_token());
    } else {
      add(stamp);
    }
  }

  std::mt19937 random_{5};
  std::uint64_t volume_index_ = 0;
  std::uint32_t index_ = 0;
  std::uint32_t frames_ = 10;
  bool announces_ = true;
  bool stands_ = false;
};

TEST_P(Counting, TheSumHoldsAtEveryMomentOfADisorderlySource) {
  const Watcher watcher(counters_);
  std::optional<FrameStamp> held;
  for (int i = 0; i < 30'000; ++i) {
    FrameStamp stamp = next_stamp();
    disturb(stamp);
    if (chance(2) && !held) {
      held = stamp;
    } else {
      give(stamp);
    }
    if (held && chance(30)) {
      give(*held);
      held.reset();
    }
    if (chance(1)) give(stamp);  // repeated frame
    if (random_() % 1000 == 0) assembler_.abandon();
    expect_identity();
    ASSERT_FALSE(HasFailure()) << "at frame " << i;
  }
  assembler_.end_of_source();
  EXPECT_EQ(assembler_.frames_pending(), 0U);
  expect_identity();
  const AcquisitionCounters& counters = counters_;
  for (const Counter* counter :
       {&counters.frames_assembled, &counters.frames_invalid, &counters.frames_damaged, &counters.frames_cut,
        &counters.frames_misfit, &counters.frames_repeated, &counters.frames_late,
        &counters.frames_over_capacity, &counters.frames_in_short_volumes,
        &counters.frames_in_incomplete_volumes, &counters.frames_abandoned, &counters.frames_missing,
        &counters.frames_reordered, &counters.sequence_restarts, &counters.volumes_short,
        &counters.volumes_incomplete, &counters.volumes_interpolated, &counters.geometry_changes,
        &counters.mismatch_refusals}) {
    EXPECT_GT(counter->value(), 0U) << "a case that this test did not reach";
  }
}

INSTANTIATE_TEST_SUITE_P(Sweeps, Counting, testing::Values(SweepCut::kByIndex, SweepCut::kByTurning),
                         [](const testing::TestParamInfo<SweepCut>& cut) {
                           return cut.param == SweepCut::kByIndex ? "ByIndex" : "ByTurning";
                         });

}  // namespace
}  // namespace fanlight
