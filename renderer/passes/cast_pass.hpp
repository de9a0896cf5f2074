// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "proto/base/result.hpp"
#include "proto/model/echo_levels.hpp"
#include "proto/model/scene.hpp"
#include "renderer/parameters/angle_table.hpp"
#include "renderer/parameters/cast_parameters.hpp"
#include "renderer/parameters/cut_mask.hpp"
#include "renderer/parameters/near_tissue.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/cast_memory.hpp"
#include "renderer/passes/depth_maps.hpp"
#include "renderer/passes/pass_recorder.hpp"
#include "renderer/rays/ray_caster.hpp"
#include "renderer/rays/tile_search.hpp"
#include "renderer/volume/angle_buffer.hpp"
#include "renderer/volume/frame_store.hpp"
#include "renderer/volume/render_workers.hpp"

namespace fanlight {

/// The parts of a volume on the GPU that pass 1 reads.
struct VolumeBindings {
  FrameStore& frames;
  AngleBuffer& angles;
  const AngleTable& table;
  const FanGeometry& geometry;
  const VolumeExtent& extent;
  const EchoLevels& levels;  ///< for what a scene leaves to the data
  const NearTissueSearch& near_tissue;
  bool frames_gone = false;  ///< frames of the next volume were staged since the cast
  TimelinePoint written;     ///< reached when the GPU has written all of it
};

/// Passes 0 and 1 of one view of a volume: the frames are prepared, and rays find the surface. The result,
/// maps(), is the input of a LightPass.
///
/// Owns its maps and its PassRecorder. Borrows the volume (VolumeBindings) for each call. Render thread only.
///
/// Life: create() -> bind(volume) -> begin(scene) -> submit_next() until submitted() -> done, when nothing is
/// outstanding -> begin() or recast() -> submit_next() until submitted(), and so on.
class CastPass {
 public:
  struct Config {
    PictureSize size;                ///< of scenes that have none
    PictureSize largest;             ///< of any scene
    std::uint64_t band_samples = 0;  ///< approximate limit of samples in one submission of pass 1
    Skipping skipping = Skipping::kOn;
    Counting counting = Counting::kOff;
    bool pauses = false;         ///< as PassRecorder::Config
    bool maps_for_host = false;  ///< LightPass::copy_by_host() reads the maps
    /// They cast the rays; then the pass's device is this processor, and the volumes are prepared on it.
    /// Null: the GPU casts the rays.
    RenderWorkers* ray_workers = nullptr;
  };

  CastPass() = default;
  /// Allocates all memory, on the device whose GPU and pipelines it uses from then on. Error: no memory on
  /// the GPU.
  static Result<CastPass> create(const PassDevice& device, const Config& config);

  /// Sets the volume that is cast; to be repeated where the volume's buffers were replaced. Precondition:
  /// nothing is outstanding.
  void bind(const VolumeBindings& volume);

  /// Builds the pipelines that casting this effective_scene() needs. Error: a pipeline that cannot be built.
  Result<void> find_pipelines(const Scene& scene, const FanGeometry& geometry);

  /// Sets pass 1 up and gives up a cast under way; submits nothing. Precondition: nothing is outstanding.
  /// Error: a pipeline that cannot be built.
  Result<void> begin(const Scene& wanted, const VolumeBindings& volume);

  /// Submits the next piece of work: a piece of pass 0 (some frames), or a band of pass 1 (some tiles of the
  /// picture; the first band comes with the upload of the tables). A piece of pass 0 that runs on the
  /// processor is done at the return; where it was the last one, pass 1 begins. Where the processor casts the
  /// rays, a band is done at the return, and what follows the last one is submitted. Precondition: nothing is
  /// outstanding.
  Result<void> submit_next(const VolumeBindings& volume);

  /// Whether the processor casts the rays.
  bool casts_here() const { return config_.ray_workers != nullptr; }
  /// Whether all bands of pass 1 were submitted, or done.
  bool submitted() const { return next_tile_ == tiles_; }
  /// Whether the next band is the last one, or in the last quarter, and not the first.
  bool nearly_submitted() const {
    return next_tile_ > 0 && tiles_ - next_tile_ <= std::max(tiles_ / 4, band_tiles_);
  }

  /// Submits one piece of pass 0 only, or runs it on the processor. Precondition: nothing is
  /// outstanding, and the frames are not done.
  Result<void> prepare_ahead(const VolumeBindings& volume);

  /// Whether the cast recorded how far its rays went, which recast() needs.
  bool notes_reach() const { return notes_reach_; }

  /// First and last index of frames that were replaced, by ascending angle.
  struct FrameRange {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
  };
  /// Submits pass 0 for replaced frames, and pass 1 for the tiles whose rays they can have changed (dirty
  /// tiles). Where the processor runs pass 0, that is done at the return; where it casts the rays,
  /// submit_next() does the rest until submitted(). Precondition: notes_reach(), nothing is outstanding, the
  /// scene is that of the cast.
  Result<void> recast(const VolumeBindings& volume, FrameRange changed);

  /// Whether add_weights() has work: the scene's depth filter weighs by confidence, which is not known yet,
  /// and the frames are still those of the cast.
  bool weights_due(const Scene& wanted, const VolumeBindings& volume) const;
  /// Submits the computation of the confidence in each surface, to run before the next LightPass.
  /// Precondition: weights_due(), nothing is outstanding. Error: a pipeline that cannot be built.
  Result<void> add_weights(const Scene& wanted, const VolumeBindings& volume);
  bool weighted() const { return weighted_; }
  /// Forgets weights whose submission is held for lack of memory: a light on the same queue would wait for
  /// them in vain, since they would come after it.
  void drop_held_weights();
  /// Forgets a submission that is held for lack of memory.
  void drop_held();

  const CastMaps& maps() const { return memory_.maps; }
  /// Reached when the GPU has written the maps, or their weights.
  const TimelinePoint& maps_written() const { return maps_written_; }
  /// Whether it has. The host may read them then.
  bool maps_are_written() const {
    const SubmissionTimeline& timeline = recorder_.timeline();
    return timeline.submissions() - timeline.outstanding() >= maps_written_.value;
  }
  /// Of the maps.
  PictureSize size() const { return size_; }
  /// Changes with each begin() and recast().
  std::uint64_t number() const { return number_; }
  /// No surface lies deeper.
  double farthest_mm() const { return farthest_mm_; }

  /// When each stage of the cast ran, as PassRecorder::stage_spans(). Precondition: nothing is outstanding.
  std::array<StageSpan, kStages> stage_spans() const;

  const PassRecorder& recorder() const { return recorder_; }
  PassRecorder& recorder() { return recorder_; }

  /// Copies of the maps; without smooth_mm. Blocks until they are copied, and allocates: for tests and
  /// one-shot rendering. Precondition: nothing is outstanding.
  Result<DepthMaps> read_maps();
  /// Number of samples that the last cast read; on a processor those of all rays of a block that were read
  /// together. Blocks, as read_maps(). Precondition:
  /// Counting::kOn, nothing is outstanding, and the cast was a whole one.
  Result<std::uint64_t> read_sample_count();

 private:
  explicit CastPass(const Config& config) : config_(config), size_(config.size) {}
  void set_tiles(const Scene& scene, const shaders::CastParameters& parameters);
  void reset_times();
  Result<void> submit();
  Result<void> submit_maps(VkQueue queue);
  Result<void> submit_frames(const VolumeBindings& volume);
  void prepare_here(FrameStore& frames);
  Result<void> cast_next_here(const VolumeBindings& volume);
  void search_next_here(const VolumeBindings& volume);
  void list_dirty_tiles();
  template <typename Task>
  void run_here(std::uint32_t tiles, const Task& task);
  void cast_here(const VolumeBindings& volume, std::uint32_t first, std::uint32_t tiles);
  ray_caster::Memory ray_memory(const VolumeBindings& volume) const;
  using RecordCopies = std::function<void(VkCommandBuffer commands, const GpuBuffer& to)>;
  Result<GpuBuffer> copied(std::uint64_t bytes, const RecordCopies& record);
  void record_tables(VkCommandBuffer commands, AngleBuffer& angles);
  void record_before_rays(VkCommandBuffer commands, AngleBuffer& angles);
  bool has_work_after_rays() const;
  void record_after_rays(VkCommandBuffer commands) const;
  void record_empty_space(VkCommandBuffer commands) const;
  void record_frame_steps(VkCommandBuffer commands) const;
  void record_slices(VkCommandBuffer commands) const;
  void record_maps_for_host(VkCommandBuffer commands) const;
  void record_dirty_tiles(VkCommandBuffer commands, const FrameStore& frames,
                          FrameRange frames_changed) const;

  Config config_;
  std::optional<TransferFunction> transferred_;  // transfer function of the table on the GPU, and the step
  float transferred_step_mm_ = 0;                // that the table is for
  bool transfer_due_ = false;
  CutMask cuts_;  // of the cells on the GPU

  // Of the cast under way, or of the last one.
  PictureSize size_;
  struct CastPipelines {  // null where CastKeys names none
    VkPipeline cast = VK_NULL_HANDLE;
    VkPipeline empty_space = VK_NULL_HANDLE;
    VkPipeline frame_steps = VK_NULL_HANDLE;
    VkPipeline slice = VK_NULL_HANDLE;
    VkPipeline cast_listed = VK_NULL_HANDLE;
    VkPipeline dirty_tiles = VK_NULL_HANDLE;
  };
  CastPipelines pipelines_;
  std::uint64_t number_ = 0;
  double farthest_mm_ = 0;
  bool weighted_ = false;
  bool notes_reach_ = false;
  bool finds_empty_space_ = false;
  std::uint32_t tiles_ = 0;       // of the whole picture
  std::uint32_t band_tiles_ = 0;  // of each band
  std::uint32_t next_tile_ = 0;   // first tile of the next band
  std::uint32_t segments_in_ray_ = 0;
  bool preparing_ = false;   // pass 0 has begun
  StageSpan prepared_here_;  // where the processor ran it
  // Where casts_here().
  ray_caster::Method method_;
  std::uint32_t next_searched_ = 0;     // the tiles before it were searched
  std::optional<FrameRange> replaced_;  // of a recast, for which the dirty tiles are listed
  std::uint32_t end_tile_ = 0;          // behind the last tile to cast, or the last place in the list
  StageSpan cast_here_;                 // without what is submitted

  CastMemory memory_;
  PassRecorder recorder_;
  TimelinePoint volume_written_;  // on another pass's timeline; null where this pass prepares the volume
  TimelinePoint maps_written_;
};

}  // namespace fanlight
