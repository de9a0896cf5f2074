// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "acquisition/phantom/body_frames.hpp"
#include "acquisition/phantom/echo_model.hpp"
#include "acquisition/phantom/frame_speckle.hpp"
#include "acquisition/phantom/phantom_motor.hpp"
#include "acquisition/phantom/phantom_scene.hpp"
#include "acquisition/source/frame_source.hpp"
#include "acquisition/source/pacer.hpp"
#include "proto/base/thread_owner.hpp"

namespace fanlight {

/// Simulated probe: a motor sweeps forward and backward at a constant frame rate over a moving scene.
/// Each frame shows the scene at its own capture time. Needs no hardware and no file.
class PhantomSource final : public FrameSource {
 public:
  enum class Pace : std::uint8_t {
    /// Frames are due at their capture times. Like a probe, the source buffers a few and does not wait: older
    /// frames that the caller did not take are lost, and appear as a gap in the sequence.
    kRealTime,
    /// Frames are due at their capture times, and wait for a slow caller: none is lost.
    kPatient,
    /// Frames are due at once and none is lost. Capture times advance by the frame period from
    /// kSimulatedStartNs, so that every run is equal.
    kUnpaced,
  };
  enum class Speckle : std::uint8_t { kOn, kOff };
  /// Side lobes, and reverberation below the probe's face.
  enum class Clutter : std::uint8_t { kOn, kOff };
  /// Of Scene::kWomb.
  enum class NearWall : std::uint8_t { kOn, kOff };
  /// Whether stamps contain the volume index, the frame index and the direction. Otherwise the end of a sweep
  /// must be found from the reversal of the angle.
  enum class Index : std::uint8_t { kOn, kOff };

  /// What the probe sees: PhantomScene, or one of BodyScene.
  enum class Scene : std::uint8_t { kRelief, kFace, kWomb, kSphere, kPlane, kCyst };

  struct Config {
    double frame_rate_hz = 75;             ///< 0.1 to 1000; 35 frames take 466 ms, as in the paper
    std::uint32_t frames_per_volume = 35;  ///< 2 to 1024
    FrameKind scan = FrameKind::kCartesian;
    std::uint32_t columns = 512;  ///< 16 to 4096 pixels or lines, over 160 mm; convex lines over 70 deg
    std::uint32_t rows = 512;     ///< 16 to 4096, over 160 mm in depth or along each line
    double sweep_deg = 70;        ///< 1 to 170, half to either side
    // From the probe's face to the apex of its scan lines, and to the motor's axis. Not options of their own.
    double probe_radius_mm = 50;
    double motor_radius_mm = 30;
    std::uint64_t seed = 1;     ///< of the speckle, jitter, turning, losses and the womb
    std::uint64_t volumes = 0;  ///< number of volumes after which the source ends; 0: never
    /// Thickness of the beam across the frame (elevation) at half of the amplitude, 0 to 8. The default is
    /// about the frame distance, as for a real array: a thinner beam leaves steps between the frames of a
    /// slanted surface.
    double beam_mm = 5;
    Speckle speckle = Speckle::kOn;
    Clutter clutter = Clutter::kOn;  ///< Scene::kRelief: reverberation only, and with speckle
    EchoScale scale;                 ///< range 20 to 120 dB, gain -40 to 40 dB
    Scene scene = Scene::kRelief;
    NearWall near_wall = NearWall::kOn;
    PhantomScene::Motion motion = PhantomScene::Motion::kMoving;
    /// Mismatch of forward and backward sweeps, -4 to 4: the measured angle is the true one minus half of
    /// this in a forward frame, and plus half of this in a backward frame.
    double lag_deg = 0;
    double jitter_deg = 0;  ///< measured angles are wrong by up to this, 0 to 2; uniform distribution
    /// Sweeps end up to this many frames early or late, 0 to 16, at most half of a sweep and at most 85 deg
    /// from the middle. Stamps then do not announce the number of frames of a sweep.
    std::uint32_t turning_frames = 0;
    Index index = Index::kOn;
    double lost_percent = 0;  ///< share of the frames, 0 to 50: gaps in the sequence
    Pace pace = Pace::kRealTime;
  };

  /// Error as check_phantom(). Takes about 20 ms, most of it for the speckle; the
  /// first face in a process most of a second.
  static Result<std::unique_ptr<PhantomSource>> create(const Config& config);

  const SourceDescription& description() const override { return description_; }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override;
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) override;
  bool waits() const override { return config_.pace != Pace::kRealTime; }
  std::uint64_t longest_loss() const override {
    return config_.lost_percent > 0 ? 0 : FrameSource::longest_loss();
  }

  /// With Scene::kRelief.
  const PhantomScene& scene() const { return scene_; }
  /// With the others; null with kRelief.
  const BodyScene* bodies() const { return bodies_ ? &bodies_->scene() : nullptr; }

  /// Time of the scene at a frame's capture time.
  double scene_time_s(const FrameStamp& frame) const;

 private:
  explicit PhantomSource(const Config& config);

  /// Position of a row's pixels in the plane of a frame: pixel i lies at x = scale_mm * across_[i], at depth
  /// depth_mm + scale_mm * ahead_[i].
  struct Row {
    double scale_mm = 0;
    double depth_mm = 0;
    std::uint32_t first = 0;  ///< columns that the probe scans, from first to end; the others stay black
    std::uint32_t end = 0;
  };
  /// Values common to all pixels of a frame.
  struct Exposure {
    PhantomScene::Pose pose;
    double sine;  ///< of the motor angle
    double cosine;
  };

  Row row_of(std::uint32_t row) const;
  std::int64_t capture_time_ns(std::uint64_t sequence) const;
  FrameSpeckle speckle_of_frames() const;
  std::vector<std::int16_t> reverberation_of_pixels() const;
  FrameSpeckle::Place place() const;
  FrameStamp stamp(std::uint64_t sequence, const PhantomMotor::Position& position) const;
  bool lost(std::uint64_t sequence) const;
  void draw_row(std::uint32_t row, const Exposure& exposure, std::span<std::uint8_t> pixels);
  void find_surface(const Row& row, const Point& base, const Exposure& exposure);

  Config config_;
  PhantomMotor motor_;
  SourceDescription description_;
  PhantomScene scene_;
  FrameSpeckle speckle_;  // with Scene::kRelief
  Pacer pacer_;
  std::vector<float> across_;  // per column: lateral position, see Row
  std::vector<float> ahead_;   // per column: depth offset, see Row; at most 1
  std::vector<Row> rows_;
  EchoModel echo_;
  std::vector<std::int16_t>
      reverberation_;                     // grey level of each pixel of the first rows; below any other: none
  std::vector<std::int16_t> none_;        // the same for a row that has none
  std::unique_ptr<BodyFrames> bodies_;    // null with Scene::kRelief
  std::vector<float> surface_depths_mm_;  // of the row being drawn
  std::vector<float> depths_below_mm_;    // the same, slightly below and above it in elevation
  std::vector<float> depths_above_mm_;
  std::int64_t start_ns_ = kSimulatedStartNs;
  std::uint64_t next_sequence_ = 0;
  FrameStamp current_;
  double true_angle_rad_ = 0;  // of current_
  std::uint64_t sweep_ = 0;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
