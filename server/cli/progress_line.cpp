// SPDX-License-Identifier: Apache-2.0
#include "server/cli/progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace fanlight {

ProgressLine::ProgressLine() : terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressLine::~ProgressLine() {
  clear();
}

void ProgressLine::clear() {
  if (shown_ && terminal_) fmt::print(stderr, "\r\x1b[K");
  shown_ = false;
}

bool ProgressLine::is_due() {
  const std::int64_t interval_ns = terminal_ ? 200'000'000 : 5'000'000'000;
  const std::int64_t now = now_ns();
  if (now - told_ns_ < interval_ns) return false;
  told_ns_ = now;
  return shown_ = true;
}

void ProgressLine::print(const std::string& line) {
  if (terminal_) {
    fmt::print(stderr, "\r{}\x1b[K", line);
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

double ProgressLine::took_s() const {
  return static_cast<double>(told_ns_ - begun_ns_) * 1e-9;
}

bool ProgressLine::show_share(double share) {
  if (is_due()) print(fmt::format("{:.0f} %, {:.0f} s left", 100 * share, took_s() / share - took_s()));
  return true;
}

void ProgressLine::show_step(const std::string& step, std::uint64_t done, std::uint64_t of) {
  if (!terminal_) return;
  told_ns_ = now_ns();
  shown_ = true;
  const double left_s = done > 0 ? took_s() / static_cast<double>(done) * static_cast<double>(of - done) : 0;
  print(left_s > 0 ? fmt::format("{}, {:.0f} s left", step, left_s) : step);
}

void ProgressLine::show_count(std::uint64_t done, std::uint64_t of, const char* what) {
  if (!is_due()) return;
  const double rate_hz = static_cast<double>(done) / took_s();
  std::string line = of > 0 ? fmt::format("{} of {} {}", done, of, what) : fmt::format("{} {}", done, what);
  line += fmt::format(", {:.1f} a second", rate_hz);
  if (of > done && done > 0) line += fmt::format(", {:.0f} s left", static_cast<double>(of - done) / rate_hz);
  print(line);
}

}  // namespace fanlight
