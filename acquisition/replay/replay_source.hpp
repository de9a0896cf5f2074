// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "acquisition/replay/recording.hpp"
#include "acquisition/source/frame_source.hpp"
#include "acquisition/source/pacer.hpp"
#include "proto/exchange/replay_link.hpp"

namespace fanlight {

/// Plays a recording like a probe.
///
/// A pass plays frames of the recording in turn, forward or backward, up to its end or to a jump. Each sweep
/// of each pass is a volume with its own index. Sequence numbers and capture times continue from pass to
/// pass; between the last frame of a whole pass and the first of the next lies one mean frame period. Frames
/// that were lost during the recording are gaps in the sequence. Forward passes of Fanlight's own recordings
/// repeat every stamp and fault as the recorder got them. The first frame after a jump says that the source
/// was interrupted, as after the loss of a probe: the sweep under way is abandoned and counted.
///
/// With a ReplayLink it takes orders at each frame and reports its state. It then never ends: behind the last
/// frame, and where a frame cannot be read, it waits for the next order.
class ReplaySource final : public FrameSource {
 public:
  enum class Pace : std::uint8_t {
    /// At the recorded times, `speed` times as fast. No frame is skipped: where the caller is late, all later
    /// frames are late.
    kRecorded,
    /// Frames are due at once; capture times are the recorded ones, from kSimulatedStartNs on.
    kAsFastAsTaken,
  };
  using Ending = ReplayEnding;

  struct Config {
    Recording::Config recording;
    Pace pace = Pace::kRecorded;
    double speed = 1;  ///< kLeastReplaySpeed to kMostReplaySpeed; used with kRecorded only
    Ending ending = Ending::kOnce;
    double from_s = 0;           ///< begins with the sweep at this time since the first frame
    bool paused = false;         ///< plays one sweep and waits for orders; needs the link
    ReplayLink* link = nullptr;  ///< must outlive the source; nullptr: it is not controlled
  };

  /// With Ending::kOnce, frames are read from the file as they are played; else all of them now. Errors as of
  /// Recording::open, and kInvalidArgument for the speed or the begin.
  static Result<std::unique_ptr<ReplaySource>> create(const Config& config);

  const SourceDescription& description() const override { return description_; }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override;
  bool waits() const override { return true; }
  std::uint64_t longest_loss() const override { return 0; }
  bool rests() const override { return rests_; }
  FrameFault known_fault() const override;
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) override;

  /// Times that it fell 100 ms behind the recorded times, which then move on.
  std::uint64_t delays() const override { return delays_; }

  const RecordingSummary& summary() const { return recording_.summary(); }
  const Recording& recording() const { return recording_; }

 private:
  using State = ReplayStatus::State;
  ReplaySource(const Config& config, Recording recording);

  std::uint32_t frames() const { return static_cast<std::uint32_t>(recording_.frames().size()); }
  /// Index in the recording of the frame at a position of this pass, or the other way round.
  std::uint32_t turned(std::uint32_t index) const { return backward_ ? frames() - 1 - index : index; }
  std::int64_t in_pass_ns(std::uint32_t frame) const;
  std::int64_t played_ns(std::int64_t recorded_ns) const;  // how long a recorded duration takes
  std::int64_t capture_time_ns() const;                    // of the frame current_
  FrameStamp next_stamp();
  void renumber();
  FrameStamp stamp() const;
  FrameStamp recorded_stamp() const;
  bool repeats_stamps() const { return recording_.stream() != nullptr && !backward_; }

  void take_orders();
  void take(const ReplayOrder& order);
  void play();
  void step(std::int32_t sweeps);
  void seek(double time_s);
  void show_frame(std::uint64_t number);
  void jump_to_sweep(std::uint32_t sweep);
  void rest_after_sweep(std::uint32_t sweep);
  void begin_pass(bool backward);
  void anchor(std::int64_t now_ns, std::int64_t pass_ns);
  std::uint32_t sweep_at(double time_s) const;
  /// What happens behind the last frame of a pass. False: the source rests or ends.
  Result<bool> turn_round();
  void rest(State state);
  /// Blocks until the frame current_ is due. False: it is not to be played now.
  bool wait_for_current(const std::stop_token& stop);
  void wait_for_order(const std::stop_token& stop);
  void tell();

  Recording recording_;
  Pace pace_;
  ReplayLink* link_;
  SourceDescription description_;
  Doorbell own_bell_;
  Doorbell& bell_;        // wakes the waiting for a frame's time, or for an order
  std::int64_t pass_ns_;  // duration from the first frame of a whole pass to the first of the next

  State state_ = State::kPlaying;
  double speed_;
  Ending ending_;
  bool backward_ = false;
  bool rests_ = false;
  bool jumped_ = false;                      // the next frame does not continue the last one
  std::optional<std::uint32_t> rest_after_;  // position: a step ends with this frame

  // The frame at anchor_pass_ns_ of this pass is due at anchor_ns_.
  std::int64_t anchor_ns_ = kSimulatedStartNs;
  std::int64_t anchor_pass_ns_ = 0;
  bool anchored_ = false;       // else the next frame is due now
  std::uint32_t position_ = 0;  // index in the pass of the next frame
  std::uint32_t current_ = 0;   // index in the recording of the announced frame
  std::uint64_t next_sequence_ = 0;
  std::uint64_t next_volume_ = 0;  // after the largest of the passes before
  // Added to the numbers of the recording, modulo 2^64.
  std::uint64_t sequence_shift_ = 0;
  std::uint64_t volume_shift_ = 0;
  std::int64_t next_free_ns_ = kSimulatedStartNs;  // capture time of a next frame that continues nothing
  std::uint64_t delays_ = 0;
  std::int64_t told_ns_ = 0;
  std::optional<Error> failure_;  // of the file, found while it was read
  ReplayStatus status_;
};

}  // namespace fanlight
