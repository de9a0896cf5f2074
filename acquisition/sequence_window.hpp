#pragma once

#include <cstdint>
#include <optional>

namespace fanlight {

/// Numbers of a sequence for which there is no frame, counted as they are settled.
struct SequenceGaps {
  std::uint64_t never_came = 0;
  std::uint64_t without_frame = 0;  ///< never came, or came without a frame that can be used
  std::uint64_t longest = 0;        ///< of the latter, in a row
  std::uint64_t in_a_row = 0;       ///< of the latter, up to the number settled last
};

/// Which numbers of a source's frames have come: a map of the last 64, as IPsec keeps one against replayed
/// packets (RFC 4303, section 3.4.3). A number that has not come stays open, since it may still come, until
/// it is settled: because it is 64 behind the newest, or because settle_below() says so. What is settled is
/// counted once and never taken back.
///
/// The first number expected is 0. One thread. Allocates nothing; each call takes the same time, a gap of any
/// length included.
class SequenceWindow {
 public:
  static constexpr std::uint64_t kSpan = 64;
  /// A jump by more than this, to either side, is no gap.
  static constexpr std::uint64_t kLargestJump = 1'000'000;

  enum class Arrival : std::uint8_t {
    kNewest,     ///< after all that came before
    kReordered,  ///< behind the newest, not settled, for the first time
    kRepeated,   ///< it came before
    kLate,       ///< it was settled; or 64 behind or more, where nobody knows whether it came before
    /// The sequence began anew: a jump beyond kLargestJump, or the second in a row of two successive numbers
    /// that are 64 behind or more. begin_at() is due.
    kRestart,
  };

  /// What the frame of that number is. Only mark() makes it count as having come.
  Arrival judge(std::uint64_t sequence);

  /// It came, with a frame that can be used or without. What falls out of the window is settled into `gaps`.
  /// Precondition: judged kNewest or kReordered.
  enum class Frame : std::uint8_t { kUsable, kUseless };
  void mark(std::uint64_t sequence, Frame frame, SequenceGaps& gaps);

  /// Settles all numbers below `sequence` that are still open.
  void settle_below(std::uint64_t sequence, SequenceGaps& gaps);

  /// Forgets all: the next number expected is `sequence`, and those below it are settled as no gap.
  void begin_at(std::uint64_t sequence);

  std::uint64_t next() const { return next_; }        ///< one above the newest
  std::uint64_t settled() const { return settled_; }  ///< all below it are settled

 private:
  std::uint64_t next_ = 0;
  std::uint64_t settled_ = 0;
  std::uint64_t came_ = 0;                   // bit i: the number next_ - 1 - i
  std::uint64_t usable_ = 0;                 // likewise
  std::optional<std::uint64_t> far_behind_;  // the last number judged, where it was 64 behind or more
};

}  // namespace fanlight
