// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "proto/base/clock.hpp"

namespace fanlight {

/// A line on the terminal with the progress of a job; removed with this object. Where standard error
/// is no terminal, a line of its own every five seconds. One thread.
class ProgressLine {
 public:
  ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  ~ProgressLine();

  /// "37 %, 12 s left". `share`: above 0 to 1. Always true, for a callback that may end the work.
  bool show_share(double share);
  /// "17 of 40 pictures, 3.4 a second, 7 s left". `of`: 0 where the end is not known.
  void show_count(std::uint64_t done, std::uint64_t of, const char* what);

  /// What begins now, such as "measures row 2 of 5"; at once, and on a terminal alone. `done` of `of` like
  /// ones are over, which gives the time that is left.
  void show_step(const std::string& step, std::uint64_t done = 0, std::uint64_t of = 0);

  /// Before other text is printed. The line comes back when it is due.
  void clear();

  std::function<bool(double share)> shares() {
    return [this](double share) { return show_share(share); };
  }

 private:
  /// Whether it is time for another line.
  bool is_due();
  void print(const std::string& line);
  double took_s() const;

  std::int64_t begun_ns_ = now_ns();
  std::int64_t told_ns_ = begun_ns_;
  bool terminal_;
  bool shown_ = false;
};

}  // namespace fanlight
