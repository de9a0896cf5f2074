// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "proto/exchange/render_health.hpp"
#include "proto/model/frame_origin.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "server/state/driver_watch.hpp"

namespace fanlight {

/// Decides whether the main view's picture shows what the probe sees now, and if not, why. Judged by the
/// capture time of the shown volume: an old volume that is lit again stays old. A picture is live up to an
/// age of two seconds, or of three sweeps where those take longer. Time is a parameter. Server thread only.
class PictureLiveness {
 public:
  enum class State : std::uint8_t {
    kWaiting,  ///< there was no picture yet
    kLive,
    kDelayed,  ///< pictures of new volumes come, and each is too old
    kNotLive,
    kReplay,   ///< the picture shows what a recording shows now, or where it is paused
    kFrozen,   ///< the picture shows one of the last volumes, as was asked for
    kResting,  ///< there are no viewers, so no picture is rendered
  };
  static constexpr std::size_t kStates = static_cast<std::size_t>(State::kResting) + 1;
  /// What keeps new pictures away. In order of precedence, but for the last one.
  enum class Cause : std::uint8_t {
    kNone,
    kSourceFailed,
    kSourceEnded,  ///< a recording has no more frames
    kProbeLost,
    kGpuRemade,       ///< the GPU was lost, and its new device has shown no picture yet
    kGpuHung,         ///< the GPU does not finish its work
    kNoFrames,        ///< the source sends none
    kVolumesRefused,  ///< the GPU has no room for them
    kRendererBehind,  ///< volumes come, and no picture is finished
    kSweepsDropped,   ///< frames come, and every sweep lacks too many
    kNoSweep,         ///< frames come, and no sweep has ended
    kDriverSilent,    ///< a call of the GPU's driver does not return; goes before kNoFrames
    kChangeNotShown,  ///< the picture is as its state says, but lacks a change of the scene; after the others
  };
  static constexpr std::size_t kCauses = static_cast<std::size_t>(Cause::kChangeNotShown) + 1;
  struct Report {
    State state = State::kWaiting;
    Cause cause = Cause::kNone;
    double age_s = -1;               ///< of the newest picture's volume; negative: no picture
    double pictures_per_second = 0;  ///< of new volumes or frames, over the last ones
    FrameOrigin origin = FrameOrigin::kProbe;
    std::string sentence;       ///< for people; says what holds, and why
    std::string scene_trouble;  ///< Source::scene_trouble, which is also part of `sentence`

    bool live() const { return state == State::kLive; }
    /// A display that comes now sees pictures of the source, or will within a moment.
    bool ready() const {
      return state == State::kLive || state == State::kDelayed || state == State::kReplay ||
             state == State::kFrozen || (state == State::kResting && cause == Cause::kNone);
    }
  };
  /// Where the frames come from, as one of three states.
  struct Source {
    enum class State : std::uint8_t { kRunning, kEnded, kFailed };
    State state = State::kRunning;
    std::string failure;  ///< a sentence, where it has failed
    bool probe_lost = false;
    std::string trouble{};   ///< a sentence, where it runs and does not give what it should
    bool is_replay = false;  ///< of a recording: its pictures are never live
    bool paused = false;     ///< a replay that sends no frame, as was asked for
    bool resting = false;    ///< nothing is rendered, since there are no viewers
    bool frozen = false;     ///< one of the last volumes is shown, as was asked for
    FrameOrigin origin = FrameOrigin::kProbe;
    std::string scene_trouble{};  ///< why a change of the scene is not shown, a sentence; empty: all are
  };

  /// `pipeline` must outlive this object. `start_ns`: fanlight::now_ns of the start.
  PictureLiveness(const PipelineCounters& pipeline, std::int64_t start_ns);

  /// The main view shows another picture.
  void shown(const PictureStamp& stamp, std::int64_t now_ns);

  /// The render thread has published its health.
  void health_changed(const RenderHealth& health);
  const RenderHealth& health() const { return health_; }

  /// Whether the renderer makes pictures: it has a volume, a device, and viewers. By the last update().
  bool renders() const;

  /// Brings the report up to date; call it several times a second. Whether state or cause changed.
  bool update(const Source& source, std::int64_t now_ns);

  const Report& report() const { return report_; }

  /// "waiting", "live", "delayed", "not live", "replay", "frozen" or "resting".
  static const char* name(State state);

  /// "none", "probe lost" and so on.
  static const char* name(Cause cause);

  /// How long a call of the GPU's driver has not returned; 0 where it answers.
  std::int64_t driver_silent_ns() const { return driver_.silent_ns(); }

  /// How long the GPU's new device has shown no picture after a loss, although one is expected; 0: it has, or
  /// none was lost. Time counts only while update() is called.
  std::int64_t gpu_lost_ns() const { return gpu_lost_ns_; }

  /// Greatest age of a live picture.
  std::int64_t limit_ns() const;

 private:
  /// A count, and when it last grew.
  struct Growth {
    std::uint64_t count = 0;
    std::uint64_t before_progress = 0;  // the count when a new volume was last shown
    std::int64_t grown_ns = 0;

    void see(std::uint64_t value, std::int64_t now_ns);
    bool since(std::int64_t time_ns) const { return grown_ns > time_ns; }
  };
  void count(std::int64_t now_ns);
  void count_loss(const Source& source, std::int64_t now_ns);
  bool lacks_new_picture(const Source& source, std::int64_t now_ns) const;
  Cause cause(const Source& source, std::int64_t now_ns) const;
  Cause cause_of_stillness(std::int64_t now_ns) const;
  Cause cause_of_replay(std::int64_t now_ns) const;
  State state(const Source& source, Cause cause, std::int64_t now_ns) const;
  bool frames_silent(std::int64_t now_ns) const;
  double rate() const;
  std::string sentence(const Source& source, std::int64_t now_ns) const;
  std::string live_sentence() const;
  std::string delay_sentence(std::int64_t now_ns) const;
  std::string replay_sentence(const Source& source) const;
  std::string frozen_sentence(const Source& source, std::int64_t now_ns) const;
  std::string reason(const Source& source, std::int64_t now_ns) const;

  const PipelineCounters& pipeline_;
  RenderHealth health_;
  DriverWatch driver_;
  bool awaits_new_device_ = false;   // the GPU was lost, and no picture of another device came yet
  std::int64_t lost_ns_ = 0;         // when that was noticed
  std::int64_t device_back_ns_ = 0;  // when the new device was there
  std::int64_t gpu_lost_ns_ = 0;
  std::int64_t updated_ns_ = 0;
  bool any_picture_ = false;  // since the last rest
  bool has_rested_ = false;
  std::int64_t captured_ns_ = 0;       // of the newest picture's volume
  std::uint64_t volume_id_ = 0;        // its number
  std::int64_t sweep_ns_ = 0;          // its duration
  std::int64_t frame_ns_ = 0;          // from frame to frame
  std::int64_t progressed_ns_ = 0;     // when a new volume, or a new frame of it, was last shown
  std::deque<std::int64_t> progress_;  // the last such times
  Growth frames_;
  Growth volumes_;
  Growth dropped_;
  Growth refused_;
  Report report_;
};

}  // namespace fanlight
