// SPDX-License-Identifier: Apache-2.0
// Decisions of the USB source without a bus: states, silence, repairs, back-off, numbers.

#include <gtest/gtest.h>

#include <array>

#include "acquisition/usb/recovery_policy.hpp"
#include "acquisition/usb/source_state.hpp"
#include "acquisition/usb/stream_numbering.hpp"
#include "tests/support/milliseconds.hpp"

namespace fanlight {
namespace {

TEST(SourceStateTable, EveryTransition) {
  struct Row {
    SourceState from;
    SourceEvent event;
    SourceState to;
  };
  using S = SourceState;
  using E = SourceEvent;
  constexpr std::array kRows = {
      Row{S::kWaiting, E::kProbeOpened, S::kStarting},
      Row{S::kStarting, E::kStarted, S::kStreaming},
      Row{S::kStarting, E::kProbeLost, S::kWaiting},
      Row{S::kStreaming, E::kReadFailed, S::kRepairing},
      Row{S::kStreaming, E::kSilent, S::kRestarting},
      Row{S::kRepairing, E::kRepaired, S::kStreaming},
      Row{S::kRepairing, E::kRepairedTooOften, S::kResetting},
      Row{S::kRepairing, E::kProbeLost, S::kWaiting},
      Row{S::kRestarting, E::kStarted, S::kStreaming},
      Row{S::kRestarting, E::kRepairedTooOften, S::kResetting},
      Row{S::kRestarting, E::kProbeLost, S::kWaiting},
      Row{S::kResetting, E::kProbeLost, S::kWaiting},
  };
  for (int from = 0; from <= static_cast<int>(S::kStopped); ++from) {
    for (int event = 0; event < static_cast<int>(E::kStop); ++event) {
      const auto state = static_cast<S>(from);
      S expected = state;  // an unexpected event changes nothing
      for (const Row& row : kRows) {
        if (row.from == state && static_cast<int>(row.event) == event) expected = row.to;
      }
      EXPECT_EQ(next_state(state, static_cast<E>(event)), expected)
          << "state " << from << ", event " << event;
    }
    EXPECT_EQ(next_state(static_cast<S>(from), E::kStop), S::kStopped) << "state " << from;
  }
}

TEST(SilenceWatch, SeesMissingBytesAndMissingFrames) {
  SilenceWatch silence;
  silence.polled(1000 * kMs);
  silence.stream_started(1000 * kMs);
  EXPECT_FALSE(silence.without_bytes(2499 * kMs));
  EXPECT_TRUE(silence.without_bytes(2500 * kMs));
  EXPECT_FALSE(silence.without_frames(2500 * kMs));
  EXPECT_TRUE(silence.without_frames(2500 * kMs + 1));

  silence.bytes_received(2000 * kMs);
  EXPECT_FALSE(silence.without_bytes(3499 * kMs));
  EXPECT_TRUE(silence.without_frames(2501 * kMs)) << "bytes are no frame";
  silence.frame_received(2400 * kMs);
  EXPECT_FALSE(silence.without_frames(3900 * kMs));
}

TEST(SilenceWatch, ABlockedCallerIsNoSilenceOfTheProbe) {
  SilenceWatch silence;
  silence.polled(1000 * kMs);
  silence.stream_started(1000 * kMs);
  silence.polled(1200 * kMs);
  EXPECT_TRUE(silence.without_bytes(2500 * kMs)) << "a gap of 200 ms is still a poll";
  silence.polled(3000 * kMs);
  EXPECT_FALSE(silence.without_bytes(4499 * kMs)) << "the caller was blocked for 1.8 s";
  EXPECT_TRUE(silence.without_bytes(4500 * kMs));
  EXPECT_FALSE(silence.without_frames(4500 * kMs));
}

TEST(RepairLimit, AllowsThreeRepairsWithoutAFrame) {
  RepairLimit limit;
  for (int repair = 0; repair < 3; ++repair) EXPECT_TRUE(limit.allows_repair());
  EXPECT_FALSE(limit.allows_repair());
  limit.frame_completed();
  EXPECT_TRUE(limit.allows_repair());
  EXPECT_TRUE(limit.allows_repair());
  limit.probe_opened();
  for (int repair = 0; repair < 3; ++repair) EXPECT_TRUE(limit.allows_repair());
  EXPECT_FALSE(limit.allows_repair());
}

TEST(ReturnBackoff, DoublesTheDelayAndResetsEveryThirdTime) {
  struct Row {
    bool had_frames;
    bool reset;
    std::int64_t delay_ms;
  };
  constexpr std::array kRows = {
      Row{true, false, 250},  Row{false, false, 500},  Row{false, false, 1000},
      Row{false, true, 2000}, Row{false, false, 4000}, Row{false, false, 4000},
      Row{false, true, 4000}, Row{true, false, 250},   Row{false, false, 500},
  };
  ReturnBackoff backoff;
  for (std::size_t loss = 0; loss < kRows.size(); ++loss) {
    const auto decision = backoff.probe_lost(kRows[loss].had_frames);
    EXPECT_EQ(decision.reset_probe, kRows[loss].reset) << "loss " << loss;
    EXPECT_EQ(decision.search_delay_ns, kRows[loss].delay_ms * kMs) << "loss " << loss;
  }
}

TEST(StreamNumbering, ContinuesAfterTheLargestNumber) {
  StreamNumbering numbering;
  numbering.stream_started();
  EXPECT_EQ(numbering.sequence(0), 0U);
  EXPECT_EQ(numbering.sequence(7), 7U);
  EXPECT_EQ(numbering.sequence(5), 5U) << "reordered";
  EXPECT_EQ(numbering.volume_index(2), 2U);
  numbering.stream_started();
  EXPECT_EQ(numbering.sequence(0), 8U);
  EXPECT_EQ(numbering.volume_index(0), 3U);
  numbering.stream_started();
  numbering.stream_started();
  EXPECT_EQ(numbering.sequence(1), 10U) << "a stream without frames uses no numbers";
}

TEST(StreamNumbering, AnAbsurdNumberDoesNotWrap) {
  StreamNumbering numbering;
  numbering.stream_started();
  EXPECT_EQ(numbering.sequence(~std::uint64_t{0}), StreamNumbering::kMostSequence);
  numbering.stream_started();
  EXPECT_EQ(numbering.sequence(0), StreamNumbering::kMostSequence + 1);
}

}  // namespace
}  // namespace fanlight
