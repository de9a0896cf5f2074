// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/sequence_window.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

SequenceWindow::Arrival SequenceWindow::judge(std::uint64_t sequence) {
  const std::optional<std::uint64_t> before = std::exchange(far_behind_, std::nullopt);
  if (sequence >= next_) {
    if (sequence - next_ > kLargestJump) return Arrival::kRestart;
    return sequence >= settled_ ? Arrival::kNewest : Arrival::kLate;
  }
  const std::uint64_t behind = next_ - 1 - sequence;
  if (behind > kLargestJump) return Arrival::kRestart;
  if (behind >= kSpan) {
    if (before && sequence == *before + 1) return Arrival::kRestart;
    far_behind_ = sequence;
    return Arrival::kLate;
  }
  if ((arrived_ >> behind & 1) != 0) return Arrival::kRepeated;
  return sequence >= settled_ ? Arrival::kReordered : Arrival::kLate;
}

void SequenceWindow::mark(std::uint64_t sequence, Frame frame, SequenceGaps& gaps) {
  if (sequence >= next_) {
    const std::uint64_t next = sequence + 1;
    if (next > kSpan) settle_below(next - kSpan, gaps);
    const std::uint64_t shift = next - next_;
    arrived_ = shift < kSpan ? arrived_ << shift : 0;
    usable_ = shift < kSpan ? usable_ << shift : 0;
    next_ = next;
  }
  const std::uint64_t bit = std::uint64_t{1} << (next_ - 1 - sequence);
  arrived_ |= bit;
  if (frame == Frame::kUsable) usable_ |= bit;
}

void SequenceWindow::settle_below(std::uint64_t sequence, SequenceGaps& gaps) {
  // At most kSpan iterations: all older numbers are settled.
  for (; settled_ < std::min(sequence, next_); ++settled_) {
    const std::uint64_t behind = next_ - 1 - settled_;
    if ((arrived_ >> behind & 1) == 0) ++gaps.never_arrived;
    if ((usable_ >> behind & 1) != 0) {
      gaps.present_run = 0;
      continue;
    }
    ++gaps.without_frame;
    gaps.longest = std::max(gaps.longest, ++gaps.present_run);
  }
  if (settled_ >= sequence) return;
  const std::uint64_t skipped = sequence - settled_;
  gaps.never_arrived += skipped;
  gaps.without_frame += skipped;
  gaps.present_run += skipped;
  gaps.longest = std::max(gaps.longest, gaps.present_run);
  settled_ = sequence;
}

void SequenceWindow::begin_at(std::uint64_t sequence) {
  *this = {};
  next_ = sequence;
  settled_ = sequence;
}

}  // namespace fanlight
