// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "proto/base/result.hpp"
#include "tests/usb/fault.hpp"

namespace fanlight::test {

/// Schedule of faults, from a text of parts separated by semicolons, each with a time and a fault:
///
///   at 2s FAULT            2 s after the beginning
///   after 300ms FAULT      300 ms after the previous part, which must not be an `every`
///   every 5s FAULT         repeatedly
///   frame 100 FAULT        directly before frame 100 goes on the pipe, counted from 0 (ProbeModel's
///                          frames_offered()), independent of its sequence number
///   every 50 frames FAULT  before the frames 50, 100, 150 and so on
///   repeat                 at the end, alone: after all parts except `every`, the script starts again
///
/// Durations are whole numbers with ms or s. The faults are fault_words(): "at 4s noise 1000; at 9s silent
/// 1500ms". Time is a parameter and must not decrease. One thread at a time.
class FaultScript {
 public:
  /// kInvalidArgument with a message that quotes the first wrong part. A text of spaces is an empty script.
  static Result<FaultScript> parse(std::string_view text);

  /// The zero of the times.
  void begin(std::int64_t now_ns);

  /// Faults that have become due since the last call, in the order of the text.
  std::vector<Fault> due(std::int64_t now_ns);
  /// The same for faults scheduled by frame, when `frame` is the next frame on the pipe.
  std::vector<Fault> before_frame(std::uint64_t frame, std::int64_t now_ns);

  /// Next time at which due() returns something; nullopt where none is known.
  std::optional<std::int64_t> next_ns() const;

 private:
  enum class Moment : std::uint8_t { kAt, kAfter, kEveryDuration, kFrame, kEveryFrames };
  struct Part {
    Moment moment = Moment::kAt;
    std::int64_t duration_ns = 0;
    std::uint64_t frames = 0;
    Fault fault;
    std::optional<std::int64_t> happened_ns;  // in this repetition
    std::uint64_t times = 0;                  // executions of an `every`

    bool recurs() const { return moment == Moment::kEveryDuration || moment == Moment::kEveryFrames; }
  };

  static Result<Part> parse_part(std::string_view text);
  std::optional<std::int64_t> due_ns(std::size_t part) const;
  bool frame_has_come(const Part& part, std::uint64_t frame) const;
  void happen(Part& part, std::int64_t at_ns, std::vector<Fault>& faults);
  void begin_round_if_over();

  std::vector<Part> parts_;
  bool repeats_ = false;
  std::optional<std::int64_t> began_ns_;
  std::int64_t round_ns_ = 0;      // start of this repetition
  std::uint64_t round_frame_ = 0;  // and its first frame
  std::uint64_t last_frame_ = 0;   // of the last before_frame()
};

}  // namespace fanlight::test
