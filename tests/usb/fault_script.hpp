#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "proto/result.hpp"
#include "tests/usb/fault.hpp"

namespace fanlight::test {

/// When which fault happens, from a text of parts between semicolons, each a moment and a fault:
///
///   at 2s FAULT            2 s after the beginning
///   after 300ms FAULT      300 ms after the part before it, which must not be an `every`
///   every 5s FAULT         again and again
///   frame 100 FAULT        just before frame 100 goes on the pipe, counted from 0 (ProbeModel's
///                          frames_offered()) whatever its sequence number is
///   every 50 frames FAULT  before the frames 50, 100, 150 and so on
///   repeat                 at the end, alone: when all parts but the `every` have happened, they begin anew
///
/// Durations are whole numbers with ms or s. The faults are fault_words(): "at 4s noise 1000; at 9s silent
/// 1500ms". Time is passed in and must not go back. One thread at a time.
class FaultScript {
 public:
  /// kInvalidArgument with a sentence that quotes the first part that is not understood. A text of spaces is
  /// a script in which nothing happens.
  static Result<FaultScript> parse(std::string_view text);

  /// The moment from which the times count.
  void begin(std::int64_t now_ns);

  /// Faults whose time has come since the last call, in the order of the text.
  std::vector<Fault> due(std::int64_t now_ns);
  /// The same for those that wait for a frame, when frame number `frame` is the next on the pipe.
  std::vector<Fault> before_frame(std::uint64_t frame, std::int64_t now_ns);

  /// When due() will next have something; nullopt where only a frame, or nothing, can bring it about.
  std::optional<std::int64_t> next_ns() const;

 private:
  enum class Moment : std::uint8_t { kAt, kAfter, kEveryDuration, kFrame, kEveryFrames };
  struct Part {
    Moment moment = Moment::kAt;
    std::int64_t duration_ns = 0;
    std::uint64_t frames = 0;
    Fault fault;
    std::optional<std::int64_t> happened_ns;  // in this round
    std::uint64_t times = 0;                  // that an `every` happened

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
  std::int64_t round_ns_ = 0;      // when this round began
  std::uint64_t round_frame_ = 0;  // and before which frame
  std::uint64_t last_frame_ = 0;   // that before_frame() was told
};

}  // namespace fanlight::test
