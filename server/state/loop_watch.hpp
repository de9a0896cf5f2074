// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "proto/exchange/pulse.hpp"

namespace fanlight {

/// Checks whether the loops of the process move, from their pulses. Time is a parameter. One thread.
class LoopWatch {
 public:
  struct Loop {
    std::string name;
    const Pulse* pulse = nullptr;
    std::function<bool()> runs;  ///< false: it has ended, and need not move
  };

  /// A loop stands still where its pulse has not beaten for longer than `most_still_ns`.
  LoopWatch(std::vector<Loop> loops, std::int64_t most_still_ns, std::int64_t now_ns);

  /// The first loop that stands still; null: all move. Call it once a second.
  const Loop* still(std::int64_t now_ns);

 private:
  struct Watched {
    Loop loop;
    std::uint64_t beats = 0;
    std::int64_t moved_ns = 0;
  };
  std::vector<Watched> loops_;
  std::int64_t most_still_ns_;
};

}  // namespace fanlight
