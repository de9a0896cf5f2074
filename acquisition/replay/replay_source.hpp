// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "acquisition/replay/recording.hpp"
#include "acquisition/source/frame_source.hpp"
#include "acquisition/source/pacer.hpp"

namespace fanlight {

/// Plays a recording like a probe.
///
/// A pass plays all frames of the recording once, forward or backward. Each sweep of each pass is a volume
/// with its own index. Sequence numbers and capture times continue from pass to pass, with one mean frame
/// period between the last frame of a pass and the first of the next. Frames that were lost during the
/// recording are gaps in the sequence. Forward passes of Fanlight's own recordings repeat every stamp and
/// fault as the recorder got them.
class ReplaySource final : public FrameSource {
 public:
  enum class Pace : std::uint8_t {
    /// At the recorded times, `speed` times as fast. No frame is skipped: where the caller is late, all later
    /// frames are late.
    kRecorded,
    /// Frames are due at once; capture times are the recorded ones, from kSimulatedStartNs on.
    kAsFastAsTaken,
  };
  enum class Ending : std::uint8_t {
    kOnce,     ///< the source ends after one pass
    kLoop,     ///< repeated forward passes, without end
    kToAndFro  ///< alternating forward and backward passes, like a motor: a single sweep gives both
               ///< directions
  };

  struct Config {
    Recording::Config recording;
    Pace pace = Pace::kRecorded;
    double speed = 1;  ///< 0.01 to 1000; used with kRecorded only
    Ending ending = Ending::kOnce;
  };

  /// With Ending::kOnce, frames are read from the file as they are played; else all of them now. Errors as of
  /// Recording::open, and kInvalidArgument for the speed.
  static Result<std::unique_ptr<ReplaySource>> create(const Config& config);

  const SourceDescription& description() const override { return description_; }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override;
  FrameFault known_fault() const override;
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) override;

  /// Times that it fell 100 ms behind the recorded times, which then move on.
  std::uint64_t delays() const override { return delays_; }

  const RecordingSummary& summary() const { return recording_.summary(); }

 private:
  ReplaySource(const Config& config, Recording recording);

  bool backward_pass() const { return ending_ == Ending::kToAndFro && pass_ % 2 == 1; }
  std::int64_t capture_time_ns() const;  // of the frame current_
  FrameStamp stamp() const;
  FrameStamp recorded_stamp() const;
  bool repeats_stamps() const { return recording_.stream() != nullptr && !backward_pass(); }

  Recording recording_;
  Pace pace_;
  double speed_;
  Ending ending_;
  SourceDescription description_;
  Pacer pacer_;
  std::int64_t pass_ns_;  // duration from the first frame of a pass to the first of the next

  std::int64_t start_ns_ = kSimulatedStartNs;
  bool started_ = false;
  std::uint64_t pass_ = 0;
  std::uint32_t position_ = 0;  // index in the pass of the next frame
  std::uint32_t current_ = 0;   // index in the recording of the announced frame
  std::uint64_t next_sequence_ = 0;
  std::uint64_t next_volume_ = 0;    // after the largest of the passes before
  std::uint64_t pass_sequence_ = 0;  // next_sequence_ and next_volume_ at the begin of this pass
  std::uint64_t pass_volume_ = 0;
  std::uint64_t delays_ = 0;
  std::optional<Error> failure_;  // of the file, found while it was read
};

}  // namespace fanlight
