// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace fanlight {

/// Sequence numbers without a usable frame, counted when they are settled.
struct SequenceGaps {
  std::uint64_t never_arrived = 0;
  std::uint64_t without_frame = 0;  ///< never arrived, or arrived unusable
  std::uint64_t longest = 0;        ///< longest run of without_frame
  std::uint64_t present_run = 0;    ///< present run, up to the number settled last
};

/// Which sequence numbers have arrived: a bit map of the last 64, like the anti-replay window of IPsec (RFC
/// 4303, section 3.4.3). A number that has not arrived stays open until it is settled: when it is 64 behind
/// the newest, or by settle_below(). A settled number is counted once; the count is final.
///
/// The first expected number is 0. One thread. Allocates nothing. The time of a call does not depend on the
/// length of a gap.
class SequenceWindow {
 public:
  static constexpr std::uint64_t kSpan = 64;
  /// A larger jump, in either direction, is a restart and no gap.
  static constexpr std::uint64_t kLargestJump = 1'000'000;

  enum class Arrival : std::uint8_t {
    kNewest,     ///< above all numbers so far
    kReordered,  ///< below the newest, not settled, first arrival
    kRepeated,   ///< it arrived before
    kLate,       ///< it was settled, or is 64 or more behind, where repetitions cannot be recognised
    /// The sequence restarted: a jump beyond kLargestJump, or the second of two successive numbers that are
    /// 64 or more behind. The caller must call begin_at().
    kRestart,
  };

  /// Classifies the number of a frame. Only mark() records it as arrived.
  Arrival judge(std::uint64_t sequence);

  /// Records an arrival, with a usable frame or not. Numbers that leave the window are settled into `gaps`.
  /// Precondition: judge() returned kNewest or kReordered.
  enum class Frame : std::uint8_t { kUsable, kUseless };
  void mark(std::uint64_t sequence, Frame frame, SequenceGaps& gaps);

  /// Settles all open numbers below `sequence`.
  void settle_below(std::uint64_t sequence, SequenceGaps& gaps);

  /// Resets: the next expected number is `sequence`; lower numbers are settled without a gap.
  void begin_at(std::uint64_t sequence);

  std::uint64_t next() const { return next_; }        ///< one above the newest
  std::uint64_t settled() const { return settled_; }  ///< all below it are settled

 private:
  std::uint64_t next_ = 0;
  std::uint64_t settled_ = 0;
  std::uint64_t arrived_ = 0;                // bit i: number next_ - 1 - i arrived
  std::uint64_t usable_ = 0;                 // bit i: and was usable
  std::optional<std::uint64_t> far_behind_;  // last number judged, if it was 64 or more behind
};

}  // namespace fanlight
