// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "proto/exchange/frame_queue.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "proto/model/volume.hpp"
#include "renderer/passes/pipelines.hpp"
#include "renderer/private_renderer.hpp"
#include "renderer/schedule/main_schedule.hpp"
#include "renderer/volume_in_flight.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// Turns volumes and scenes into pictures. Two volumes are in flight: pass 1 of the next volume runs while
/// passes 2 and 3 of the last one do. A changed light re-runs passes 2 and 3 of the shown volume, a changed
/// view also pass 1; the newest scene wins. Each volume is shown by its own geometry, and the geometries of
/// the two volumes in flight may differ.
///
/// Owns the pipelines, the two volume slots and the private views. renderer/schedule decides the order of the
/// work; this class executes it.
///
/// One thread, which calls show() and load() as scenes and volumes arrive, then advance(), collect() and
/// wait() in turn.
class Renderer {
 public:
  struct Config {
    PictureSize size;
    FanGeometry geometry;        ///< of the first volumes; their memory is allocated in create()
    double first_angle_rad = 0;  ///< range in which most frames lie
    double last_angle_rad = 0;
    std::uint32_t frame_capacity = 0;  ///< most frames of any volume
    /// Frames of most volumes: their memory is allocated in create(), memory for more frames when such a
    /// volume arrives. 0: frame_capacity.
    std::uint32_t usual_frames = 0;
    Skipping skipping = Skipping::kOn;
    /// Absent: chosen by the kind of GPU.
    std::optional<Sampling> sampling;
    /// File cache of the driver's compiled pipelines; by default there is none. It is written at the end of
    /// create() and in the destructor.
    PipelineCache::Config pipeline_cache{};
  };
  /// Both must outlive the renderer.
  struct Dependencies {
    const Gpu& gpu;
    RenderCounters& counters;
  };

  /// Allocates all memory except pass 0's, which is allocated with the first volume that needs it, and builds
  /// the largest pipelines for `scene`. Errors: no memory on the GPU; a geometry, a volume or a picture
  /// beyond the GPU's limits.
  static Result<std::unique_ptr<Renderer>> create(const Config& config, const Dependencies& dependencies,
                                                  const NumberedScene& scene);
  ~Renderer();

  /// Sets the scene of all following pictures.
  void show(const NumberedScene& scene) { scene_ = scene; }

  /// Whether load() accepts a volume: no pass 1 is under way and a slot is free.
  bool wants_volume() const { return accepts_volume(status(), scene_); }

  /// Copies the volume; the next advance() casts it. A volume too large for the GPU's limits or memory is
  /// refused and counted, and the shown picture stays. Allocates where its columns or rows differ from those
  /// of the volume that it replaces, or where it has more frames than any volume before. Precondition:
  /// wants_volume(), at most frame_capacity frames. Error: the GPU is broken.
  Result<void> load(const Volume& volume);

  /// Whether take_frame() accepts a frame: the slot of the next volume is free.
  bool wants_frame() const { return accepts_frame(status(), scene_); }

  /// Copies a frame of the next volume, so that pass 0 can prepare it before the other frames arrive. Its
  /// index is estimated from its angle and the angles of the last volume; load() corrects wrong estimates.
  /// Precondition: wants_frame().
  void take_frame(const QueuedFrame& frame);

  /// Submits the work that is due and that the GPU can take now. Never waits for the GPU.
  Result<void> advance();

  /// True where a picture was finished; it was copied to `picture`, whose buffers are reused.
  bool collect(Picture& picture);

  /// When each stage of the picture collected last ran. Precondition: its slot has not taken another volume
  /// since. For benchmarks.
  std::array<StageSpan, kStages> stage_spans() const { return slots_[shown_]->slot.view().stage_spans(gpu_); }

  /// Sets the private views of what the main view shows. Allocates for each new view. Error: the GPU is
  /// broken.
  Result<void> want(const PrivateViews& views) { return private_.want(views); }

  /// Submits one piece of a private view's work where some is due and nothing is busy(); true where it did.
  /// The next work of the main view waits for that piece.
  Result<bool> advance_private();

  /// Copies finished private pictures to their mailboxes; whether there was one.
  bool collect_private() { return private_.collect(); }

  /// Whether work is outstanding on the GPU, or finished and not collected; of the main view and the private
  /// views, or of the main view only.
  bool busy() const { return main_busy() || private_.busy(); }
  bool main_busy() const;

  /// Blocks until the GPU has finished another submission, at most timeout_ns. Returns at once where nothing
  /// is outstanding.
  Result<void> wait(std::int64_t timeout_ns);

  /// The depth maps of the picture collected last. Precondition: !busy(). For tests and one-shot rendering.
  Result<DepthMaps> read_depth();

  const Config& config() const { return config_; }
  const NumberedScene& scene() const { return scene_; }

 private:
  struct SlotState {
    VolumeInFlight slot;
    WorkPhase phase = WorkPhase::kIdle;
    NumberedScene cast_scene;       // of the depth map in the slot
    NumberedScene lit_scene;        // of the picture in the slot
    std::uint64_t cast_number = 0;  // of the depth map, from 1
    PictureStamp stamp;
    bool awaits_picture = false;  // its volume has had no picture yet
    bool gave_up_cast = false;    // the cast under way replaced one whose view was outdated
    // Volume and view of the filtered depth map, which is the temporal filter's input for the next volume.
    std::uint64_t filtered_volume_id = 0;
    Scene filtered_view;
  };

  Renderer(const Config& config, const Dependencies& dependencies, const NumberedScene& scene,
           std::unique_ptr<Pipelines> pipelines, const ViewRenderer::Config& private_views)
      : config_(config),
        gpu_(dependencies.gpu),
        counters_(dependencies.counters),
        pipelines_(std::move(pipelines)),
        private_(gpu_, *pipelines_, counters_, private_views),
        scene_(scene) {}
  MainStatus status() const;
  Result<void> execute(MainStep step);
  Result<void> begin_cast(SlotState& state);
  Result<void> recast(SlotState& state);
  Result<void> light(SlotState& state);
  Result<void> prepare_ahead();
  Result<void> load_into_other(const Volume& volume);
  Result<void> complete_newest(const Volume& volume);
  void count_cast(SlotState& state);
  std::uint32_t nearest_frame_index(double angle_rad) const;
  bool replaces_frames() const {
    const SlotState& newest = *slots_[newest_];
    return fanlight::replaces_frames(newest.slot.loaded(), newest.cast_scene, scene_);
  }
  VolumeInFlight::History history_of(const SlotState& state) const;

  Config config_;
  const Gpu& gpu_;
  RenderCounters& counters_;
  std::unique_ptr<Pipelines> pipelines_;
  std::array<std::unique_ptr<SlotState>, 2> slots_;
  PrivateRenderer private_;
  std::size_t newest_ = 0;  // slot loaded last; the other one takes the next volume
  std::size_t shown_ = 0;   // slot whose picture was collected last
  std::uint64_t shown_volume_id_ = 0;
  std::uint64_t newest_commit_number_ = 0;  // largest of the frames of the last volume
  NumberedScene scene_;
  std::uint64_t pictures_ = 0;
};

}  // namespace fanlight
