// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace fanlight {

/// Continues the numbers of frames and sweeps over restarts: a probe counts from 0 with each start of its
/// stream, the numbers in FrameStamps only grow from stream to stream. One thread.
class StreamNumbering {
 public:
  /// Larger sequence numbers of a probe are cut to this one: they must not make the sum wrap.
  static constexpr std::uint64_t kMostSequence = std::uint64_t{1} << 48;

  /// The next stream continues after the largest numbers so far.
  void stream_started() {
    sequence_.first = sequence_.next;
    volume_.first = volume_.next;
  }

  std::uint64_t sequence(std::uint64_t of_probe) {
    return sequence_.continued(std::min(of_probe, kMostSequence));
  }
  std::uint64_t volume_index(std::uint32_t of_probe) { return volume_.continued(of_probe); }

 private:
  struct Count {
    std::uint64_t first = 0;  // of this stream
    std::uint64_t next = 0;   // after the largest so far

    std::uint64_t continued(std::uint64_t of_probe) {
      const std::uint64_t number = first + of_probe;
      next = std::max(next, number + 1);
      return number;
    }
  };
  Count sequence_;
  Count volume_;
};

}  // namespace fanlight
