// SPDX-License-Identifier: Apache-2.0
#include "server/cli/progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace fanlight {

ProgressLine::~ProgressLine() {
  if (shown_) fmt::print(stderr, "\r\x1b[K");
}

bool ProgressLine::is_due() {
  if (isatty(STDERR_FILENO) == 0) return false;
  constexpr std::int64_t kIntervalNs = 200'000'000;
  const std::int64_t now = now_ns();
  if (now - told_ns_ < kIntervalNs) return false;
  told_ns_ = now;
  return shown_ = true;
}

double ProgressLine::took_s() const {
  return static_cast<double>(told_ns_ - begun_ns_) * 1e-9;
}

bool ProgressLine::tell_share(double share) {
  if (is_due()) {
    fmt::print(stderr, "\r{:.0f} %, {:.0f} s left\x1b[K", 100 * share, took_s() / share - took_s());
    std::fflush(stderr);
  }
  return true;
}

void ProgressLine::tell_count(std::uint64_t done, std::uint64_t of, const char* what) {
  if (!is_due()) return;
  const double rate_hz = static_cast<double>(done) / took_s();
  std::string line = of > 0 ? fmt::format("{} of {} {}", done, of, what) : fmt::format("{} {}", done, what);
  line += fmt::format(", {:.1f} a second", rate_hz);
  if (of > done && done > 0) line += fmt::format(", {:.0f} s left", static_cast<double>(of - done) / rate_hz);
  fmt::print(stderr, "\r{}\x1b[K", line);
  std::fflush(stderr);
}

}  // namespace fanlight
