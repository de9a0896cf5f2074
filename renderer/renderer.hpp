// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "proto/base/thread_owner.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "proto/model/volume.hpp"
#include "renderer/cast_means.hpp"
#include "renderer/pipelines/pipeline_store.hpp"
#include "renderer/pipelines/pipelines.hpp"
#include "renderer/private_renderer.hpp"
#include "renderer/schedule/main_schedule.hpp"
#include "renderer/schedule/scene_fallback.hpp"
#include "renderer/schedule/watchdog.hpp"
#include "renderer/survey/echo_survey.hpp"
#include "renderer/survey/near_tissue_survey.hpp"
#include "renderer/volume_in_flight.hpp"
#include "renderer/vulkan/device_health.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// Turns volumes and scenes into pictures. Two volumes are in flight: pass 1 of the next volume runs while
/// passes 2 and 3 of the last one do. A changed light re-runs passes 2 and 3 of the shown volume, a changed
/// view also pass 1; the newest scene wins. Each volume is shown by its own geometry, and the geometries of
/// the two volumes in flight may differ.
///
/// Owns the two volume slots and the private views. renderer/schedule decides the order of the work; this
/// class executes it.
///
/// One thread, which calls show() and load() as scenes and volumes arrive, then advance(), collect() and
/// wait() in turn.
///
/// Errors: kLost where the GPU was lost or hangs, kBroken where a call failed otherwise, kUnavailable where
/// its memory ran out in a place that has no way round. After any of them, and unless a function says
/// otherwise, the renderer is of no more use; a new one on a new device may be. A wait never lasts longer
/// than the watchdog allows.
class Renderer {
 public:
  struct Config {
    PictureSize size;  ///< of scenes that have none
    /// The largest of any scene, whose memory is allocated in create(). Absent: `size`.
    std::optional<PictureSize> largest_size;
    FanGeometry geometry;        ///< of the first volumes; their memory is allocated in create()
    double first_angle_rad = 0;  ///< range in which most frames lie
    double last_angle_rad = 0;
    std::uint32_t frame_capacity = 0;  ///< most frames of any volume
    /// Frames of most volumes: their memory is allocated in create(), memory for more frames when such a
    /// volume arrives. 0: frame_capacity.
    std::uint32_t usual_frames = 0;
    Skipping skipping = Skipping::kOn;
    Counting counting = Counting::kOff;
    /// Absent: chosen by the kind of GPU and the size of `geometry`.
    std::optional<Sampling> sampling;
    /// The shader casts the rays also where the processor does it faster itself: for comparisons.
    bool rays_by_shader = false;
    /// Samples that a band of pass 1 takes at most; private views have smaller ones. Absent: chosen by the
    /// kind of GPU.
    std::optional<std::uint64_t> band_samples;
    /// File cache of the driver's compiled pipelines; by default there is none. It is written at the end of
    /// create() and in the destructor.
    PipelineCache::Config pipeline_cache{};
    /// Absent: chosen by the kind of GPU.
    std::optional<Watchdog::Limits> watchdog{};

    PictureSize largest() const { return largest_size.value_or(size); }
  };
  /// All must outlive the renderer.
  struct Dependencies {
    const Gpu& gpu;
    RenderCounters& counters;
    /// The device of passes 2 and 3 of the main view; null: `gpu`. With RenderDevice::light_gpu they run
    /// at the same time as pass 1 on a processor too. Ignored where the processor casts the rays itself. A
    /// fault of one device counts as a fault of both.
    const Gpu* light_gpu = nullptr;
    /// Keeps the pipelines for the next renderer on these devices; null: they end with this renderer.
    PipelineStore* store = nullptr;
  };

  /// Allocates all memory except pass 0's, which is allocated with the first volume that needs it, and builds
  /// the largest pipelines for `scene`. Errors: no memory on the GPU; a geometry, a volume or a picture
  /// beyond the GPU's limits.
  static Result<std::unique_ptr<Renderer>> create(const Config& config, const Dependencies& dependencies,
                                                  const NumberedScene& scene);
  /// Waits for the GPU as long as the watchdog allows. Objects that a hung GPU may still use are not
  /// destroyed.
  ~Renderer();

  /// Sets the scene of all following pictures. A scene whose pipelines the driver does not build is refused
  /// when its turn comes, and the one before stays; it is tried again later.
  void show(const NumberedScene& scene);

  /// The scene of show(), and why it is not shown where it is not.
  const SceneFallback& scenes() const { return scenes_; }

  /// Whether load() accepts a volume: no pass 1 is under way and a slot is free.
  bool wants_volume() const { return accepts_volume(status(), scene_in_force()); }

  /// Only a kNew volume is counted. kAgain: a renderer before this one has loaded it. kKept: one of the last
  /// volumes, of the cine; the grey levels in force stay.
  enum class Loading : std::uint8_t { kNew, kAgain, kKept };

  /// Copies the volume; the next advance() casts it. Allocates where its columns or rows differ from those of
  /// the volume that it replaces, or where it has more frames than any volume before. Precondition:
  /// wants_volume(), at most frame_capacity frames. Errors: kUnsupported and kUnavailable where the volume is
  /// too large for the GPU's limits or memory: it is counted as refused, the shown picture stays, and the
  /// renderer continues. kLost and kBroken as above.
  Result<void> load(const Volume& volume, Loading loading = Loading::kNew);

  /// The levels of all volumes from now on: they are not measured any more. For the pictures of a recording.
  void fix_levels(const EchoLevels& levels) { fixed_levels_ = levels; }

  /// Whether the volume shown was cast without the speckle filter of its scene, for lack of memory.
  bool filter_left_out() const { return slots_[shown_]->slot.filter_left_out(); }

  /// Bytes of the largest volume that was loaded; 0: none.
  std::uint64_t largest_volume_bytes() const { return largest_volume_bytes_; }

  /// Whether take_frame() accepts a frame: the slot of the next volume is free.
  bool wants_frame() const { return accepts_frame(status(), scene_in_force()); }

  /// Whether frames replace those of the last volume one by one (Refresh::kFrame is in force).
  bool replaces_frames() const {
    const SlotState& newest = *slots_[newest_];
    return fanlight::replaces_frames(newest.slot.loaded(), newest.cast_scene, scene_in_force());
  }

  /// Copies a frame of the next volume, so that pass 0 can prepare it before the other frames arrive. Its
  /// index is estimated from its angle and the angles of the last volume; load() corrects wrong estimates.
  /// Precondition: wants_frame().
  void take_frame(const QueuedFrame& frame);

  /// Whether the main view begins something where it has nothing under way.
  enum class NewWork : std::uint8_t { kBegins, kWaits };
  /// Whether a volume will be loaded as soon as wants_volume().
  enum class NextVolume : std::uint8_t { kUnknown, kWaits };
  /// Submits the work that is due and that the GPU can take now. Never waits for the GPU.
  Result<void> advance(NewWork new_work = NewWork::kBegins, NextVolume next = NextVolume::kUnknown);

  /// True where a picture was finished; it was copied to `picture`, whose buffers are reused.
  bool collect(Picture& picture);

  /// When each stage of the picture collected last ran. Precondition: its slot has not taken another volume
  /// since. For benchmarks.
  std::array<StageSpan, kStages> stage_spans() const { return slots_[shown_]->slot.stage_spans(); }

  /// Sets the private views of what the main view shows. Allocates for each new view. A view that cannot be
  /// drawn ends alone; see ended_views(). Error: kLost.
  Result<void> want(const PrivateViews& views) { return private_.want(views); }

  /// The private views that ended because of an error, by index of PrivateViews; nullptr where none has since
  /// the last call.
  const PrivateViewEnds* ended_views() { return private_.ended_views(); }

  /// Submits one piece of a private view's work where some is due and nothing is busy(); true where it did.
  /// The next work of the main view waits for that piece.
  Result<bool> advance_private();
  /// Whether a private view has work to do as soon as the main view lets it, or has some under way.
  bool private_due() const;

  /// Copies finished private pictures to their mailboxes; whether there was one.
  bool collect_private() { return private_.collect(); }

  /// Whether work is outstanding on the GPU, or finished and not collected; of the main view and the private
  /// views, or of the main view only.
  bool busy() const { return main_busy() || private_.busy(); }
  bool main_busy() const;

  /// Blocks until the GPU has finished another submission, at most timeout_ns. Returns at once where nothing
  /// is outstanding. Error: kLost too where a submission takes longer than the watchdog allows.
  Result<void> wait(std::int64_t timeout_ns);

  /// Whether the cast under way makes the picture on show finer. A new volume gives it up.
  bool refines() const {
    const SlotState& newest = *slots_[newest_];
    return newest.phase == WorkPhase::kCasting && newest.refines;
  }

  /// How fast the GPU worked at the last wait().
  Watchdog::Pace pace() const { return pace_; }

  /// Waits until nothing is outstanding, at most timeout_ns. False where the GPU has not finished by then, or
  /// is lost.
  bool settle(std::int64_t timeout_ns);

  /// Counts what is in flight as given up, and touches no counters afterwards. To be called before the
  /// renderer of a lost or hung GPU is handed to a DeviceDisposal; the destructor is then the only further
  /// call.
  void give_up();

  /// Whether the devices work.
  const DeviceHealth& devices() const { return devices_; }

  /// The numbers that a new renderer continues.
  struct Progress {
    std::uint64_t pictures = 0;
    PrivateRenderer::Progress private_views;
  };
  Progress progress() const { return {.pictures = pictures_, .private_views = private_.progress()}; }
  /// Before the first want().
  void resume(const Progress& progress) {
    pictures_ = progress.pictures;
    private_.resume(progress.private_views);
  }

  /// The depth maps of the picture collected last. Precondition: !busy(). For tests and one-shot rendering.
  Result<DepthMaps> read_depth();
  /// Number of samples that the cast of that picture read. Precondition as read_depth(), and Counting::kOn.
  Result<std::uint64_t> read_sample_count() { return slots_[shown_]->slot.read_sample_count(); }

  const Config& config() const { return config_; }
  const Gpu& gpu() const { return gpu_; }

 private:
  struct SlotState {
    VolumeInFlight slot;
    WorkPhase phase = WorkPhase::kIdle;
    NumberedScene cast_scene;       // of the depth map in the slot
    NumberedScene lit_scene;        // of the picture in the slot
    std::uint64_t cast_number = 0;  // of the depth map, from 1
    PictureStamp stamp;
    bool is_kept = false;         // its volume is one of the cine's, which may be older than the one on show
    bool awaits_picture = false;  // its volume has had no picture yet
    bool refines = false;         // the cast under way makes the picture on show finer, and else the same
    bool map_lost = false;        // it was given up
    bool gave_up_cast = false;    // the cast under way replaced one whose view was outdated
    // Volume and view of the filtered depth map, which is the temporal filter's input for the next volume.
    std::uint64_t filtered_volume_id = 0;
    Scene filtered_view;
  };

  /// Of `gpu` and of `light_gpu`; the second is null where they are one.
  using AllPipelines = std::pair<std::shared_ptr<Pipelines>, std::shared_ptr<Pipelines>>;
  static Result<AllPipelines> pipelines_of(PipelineStore& store, const Dependencies& dependencies,
                                           const Pipelines::Config& config);

  Renderer(const Config& config, const Dependencies& dependencies, const NumberedScene& scene,
           AllPipelines pipelines, CastMeans means)
      : config_(config),
        gpu_(dependencies.gpu),
        light_gpu_(dependencies.light_gpu != nullptr ? *dependencies.light_gpu : dependencies.gpu),
        devices_(gpu_, light_gpu_),
        counters_(dependencies.counters),
        pipelines_(std::move(pipelines.first)),
        light_pipelines_(std::move(pipelines.second)),
        means_(std::move(means)),
        private_({&gpu_, pipelines_.get()}, counters_,
                 {.size = config.size,
                  .largest = config.size,
                  .band_samples = means_.private_band_samples(),
                  .skipping = config.skipping,
                  .pauses = true,
                  .ray_workers = means_.ray_workers()}),
        watchdog_(config.watchdog.value_or(usual_limits(gpu_))),
        scenes_(scene) {}
  MainStatus status() const;
  Result<void> execute(MainStep step);
  Result<void> begin_cast(SlotState& state);
  Result<void> begin_cast_of_scene(SlotState& state);
  bool would_refine(const SlotState& state) const;
  Result<void> recast(SlotState& state);
  Result<void> create_slots();
  Result<void> light(SlotState& state);
  Result<void> submit_light(SlotState& state);
  Result<void> submit_light_piece(SlotState& state);
  void take_light_scene(SlotState& state) const;
  void note_light(SlotState& state);
  const NumberedScene& scene_in_force() const { return scenes_.in_force(); }
  bool on_one_device() const { return devices_.on_one_device(); }
  Result<void> prepare_ahead();
  Result<void> load_into_other(const Volume& volume, Loading loading);
  Result<void> complete_newest(const Volume& volume, Loading loading);
  void count_cast(SlotState& state);
  bool falls_back(const Error& error);
  Result<void> retry_held();
  Result<void> observe();
  bool works_here() const {
    return std::ranges::any_of(slots_, [](const auto& state) {
      return state->phase == WorkPhase::kCasting && state->slot.works_here();
    });
  }
  Result<void> known_fault() const {
    const Error* const known = devices_.fault();
    return known == nullptr ? Result<void>{} : *known;
  }
  std::size_t other_than(const SlotState& state) const { return &state == slots_[0].get() ? 1 : 0; }
  VolumeInFlight::Earlier earlier_than(const SlotState& state) const;
  VolumeInFlight::Earlier picture_before(const SlotState& state) const;
  bool private_views_have_input() const;
  PrivateRenderer::Shown shown_for_private_views() const;

  Config config_;
  const Gpu& gpu_;
  const Gpu& light_gpu_;
  DeviceHealth devices_;
  RenderCounters& counters_;
  std::shared_ptr<Pipelines> pipelines_;
  std::shared_ptr<Pipelines> light_pipelines_;  // null on one device
  CastMeans means_;
  std::array<std::unique_ptr<SlotState>, 2> slots_;
  PrivateRenderer private_;
  Watchdog watchdog_;
  Watchdog::Pace pace_ = Watchdog::Pace::kUsual;
  bool given_up_ = false;
  std::size_t newest_ = 0;  // slot loaded last; the other one takes the next volume
  std::size_t shown_ = 0;   // slot whose picture was collected last
  std::uint64_t shown_volume_id_ = 0;
  std::uint64_t newest_commit_number_ = 0;  // largest of the frames of the last volume
  std::uint64_t largest_volume_bytes_ = 0;
  const EchoLevels& levels() const { return fixed_levels_ ? *fixed_levels_ : levels_.in_force(); }

  SteadyLevels levels_;
  void find_near_tissue_of(const Volume& volume, Loading loading);
  NearTissueSearch near_tissue_;  // of the volume that load() got
  SteadyNearTissue steady_near_tissue_;
  std::optional<EchoLevels> fixed_levels_;
  SceneFallback scenes_;
  std::uint64_t pictures_ = 0;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
