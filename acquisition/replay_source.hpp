#pragma once

#include <cstdint>
#include <memory>

#include "acquisition/frame_source.hpp"
#include "acquisition/pacer.hpp"
#include "acquisition/recording.hpp"

namespace fanlight {

/// Plays a recording as if it came from a probe.
///
/// A pass plays all frames of the recording once, forward or backward. Each sweep of each pass is a volume
/// with an index of its own; sequence numbers and capture times go on from pass to pass, with one mean frame
/// period between the last frame of a pass and the first of the next. Frames that were lost when the
/// recording was made are gaps in the sequence.
class ReplaySource final : public FrameSource {
 public:
  enum class Pace : std::uint8_t {
    /// At the times recorded, `speed` times as fast. No frame is skipped: where nobody takes them in time,
    /// all later frames come later.
    kRecorded,
    /// As fast as frames are taken; capture times are those recorded, from kSimulatedStartNs on.
    kAsFastAsTaken,
  };
  enum class Ending : std::uint8_t {
    kOnce,     ///< the source ends after one pass
    kLoop,     ///< passes forward for ever
    kToAndFro  ///< every other pass backward, as a motor would sweep: one sweep gives both directions
  };

  struct Config {
    Recording::Config recording;
    Pace pace = Pace::kRecorded;
    double speed = 1;  ///< 0.01 to 1000; of kRecorded alone
    Ending ending = Ending::kOnce;
  };

  /// Reads the whole file. Errors as Recording::open, and kInvalidArgument for the speed.
  static Result<std::unique_ptr<ReplaySource>> create(const Config& config);

  const SourceDescription& description() const override { return description_; }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override;
  FrameFault known_fault() const override {
    return recording_.frames()[current_].valid ? FrameFault::kNone : FrameFault::kInvalid;
  }
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) override;

  const RecordingSummary& summary() const { return recording_.summary(); }

 private:
  ReplaySource(const Config& config, Recording recording);

  bool backward_pass() const { return ending_ == Ending::kToAndFro && pass_ % 2 == 1; }
  std::int64_t capture_time_ns() const;  // of the frame current_
  FrameStamp stamp() const;

  Recording recording_;
  Pace pace_;
  double speed_;
  Ending ending_;
  SourceDescription description_;
  Pacer pacer_;
  std::int64_t pass_ns_;  // from the first frame of a pass to the first of the next

  std::int64_t start_ns_ = kSimulatedStartNs;
  bool started_ = false;
  std::uint64_t pass_ = 0;
  std::uint32_t position_ = 0;  // in the pass, of the next frame
  std::uint32_t current_ = 0;   // in the recording, of the frame announced
  std::uint64_t next_sequence_ = 0;
};

}  // namespace fanlight
