// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/model/echo_levels.hpp"
#include "proto/model/picture.hpp"
#include "renderer/parameters/angle_table.hpp"
#include "renderer/parameters/cast_parameters.hpp"
#include "renderer/parameters/light_parameters.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/descriptor_sets.hpp"
#include "renderer/passes/pipelines.hpp"
#include "renderer/view/light_regions.hpp"
#include "renderer/view/light_steps.hpp"
#include "renderer/view/pixel_rect.hpp"
#include "renderer/view/view_buffers.hpp"
#include "renderer/volume/angle_buffer.hpp"
#include "renderer/volume/frame_store.hpp"
#include "renderer/vulkan/command_recording.hpp"
#include "renderer/vulkan/gpu_timestamps.hpp"
#include "renderer/vulkan/submission_timeline.hpp"

namespace fanlight {

/// Copies of a picture's depth maps; see ViewRenderer::read_depth.
struct DepthMaps {
  std::vector<float> cast_mm;  ///< of pass 1
  /// Edge contrast divided by the noise beside the edge, 0 without a surface. Empty where the depth filter
  /// does not weigh by it.
  std::vector<float> confidence;
  std::vector<float> smooth_mm;  ///< after pass 2's filter
  /// Share of all tiles' ray segments that rays had to sample; 1 where pass 1 skips nothing.
  double sampled_share = 1;
};

/// The parts of a volume on the GPU that its views read.
struct VolumeBindings {
  FrameStore& frames;
  AngleBuffer& angles;
  const AngleTable& table;
  const FanGeometry& geometry;
  const VolumeExtent& extent;
  const EchoLevels& levels;  ///< for what a scene leaves to the data
  bool frames_gone = false;  ///< frames of the next volume were staged since the cast
  TimelinePoint written;     ///< reached when the GPU has written all of it
};

/// One view of a volume: its depth map, its picture, and the commands of the passes.
///
/// Owns the view's buffers, descriptor sets, command buffers, time stamps and timeline. Borrows the volume
/// (VolumeBindings) for each call. Render thread only.
///
/// Life: create() -> bind(volume) -> begin_cast(scene) -> cast_next_band() until cast_submitted() ->
/// light(scene) -> done, when nothing is outstanding -> and again from light() (a changed light) or
/// begin_cast() (a changed view, the next volume). Or with a copy of another view's depth map:
/// copy_cast(other) -> light(scene).
class ViewRenderer {
 public:
  struct Config {
    PictureSize size;
    std::uint64_t band_samples = 0;  ///< approximate limit of samples in one submission of pass 1
    Skipping skipping = Skipping::kOn;
    /// Pieces of other views run between this view's: stage_ms() adds up the pieces, without the pauses.
    bool pauses = false;
    ViewPasses passes = ViewPasses::kAll;
  };

  ViewRenderer() = default;
  /// Allocates all memory of the view, on the device whose GPU and pipelines it uses from then on. Error: no
  /// memory on the GPU.
  static Result<ViewRenderer> create(const PassDevice& device, const Config& config);

  /// Sets the volume that the view casts; to be repeated where the volume's buffers were replaced.
  /// Precondition for this and the next two: nothing is outstanding.
  void bind(const VolumeBindings& volume);

  /// Sets the view whose filtered depth map is the temporal filter's input: that of the volumes before and
  /// after this one's.
  void follow(const ViewRenderer& other);

  /// Takes over what another view has cast, as the first piece of light() or begin_light(), which comes next,
  /// copies it. The other view may cast again once that piece is done. `volume` is the other view's, as in
  /// bind().
  void copy_cast(const ViewRenderer& other, const VolumeBindings& volume);

  /// The same between two devices, from a view of ViewPasses::kCast to one of kLight: copies now.
  /// Passes 2 and 3 then compute only what has changed since the last picture, where that is less than half
  /// of it. Precondition: nothing of either is outstanding.
  void take_cast(const ViewRenderer& other);

  /// Takes the temporally filtered depth map of a view on another device, from ViewPasses::kLight to kCast,
  /// where follow() then finds it. Precondition: as take_cast().
  void take_steady(const ViewRenderer& other) const { memory_.take_steady(other.memory_); }

  /// Submits the computation of the weights that the depth filter of this scene asks for; false where it asks
  /// for none, where they are known, and where the frames are gone. For ViewPasses::kCast, whose frames
  /// passes 2 and 3 cannot read; the other views compute them in light(). Precondition: nothing is
  /// outstanding.
  Result<bool> add_confidence(const Scene& wanted, const VolumeBindings& volume);

  /// Builds the pipelines that casting this effective_scene() needs. Error: a pipeline that cannot be built.
  Result<void> find_cast_pipelines(const Scene& scene, FrameKind kind);

  /// Sets pass 1 up and gives up a cast under way; submits nothing. Precondition: nothing is outstanding.
  /// Error: a pipeline that cannot be built.
  Result<void> begin_cast(const Scene& wanted, const VolumeBindings& volume);

  /// Submits the next piece of work: a piece of pass 0 (some frames), or a band of pass 1 (some tiles of the
  /// picture; the first band comes with the upload of the tables). Precondition: nothing is outstanding.
  Result<void> cast_next_band(const VolumeBindings& volume);

  /// Whether all bands of pass 1 were submitted.
  bool cast_submitted() const { return next_tile_ == cast_tiles_; }

  /// Submits one piece of pass 0 only. Precondition: nothing is outstanding, and the frames are not done.
  Result<void> prepare_ahead(const VolumeBindings& volume);

  /// Whether the cast recorded how far its rays went, which recast() needs.
  bool notes_reach() const { return notes_reach_; }

  /// First and last index of frames that were replaced, by ascending angle.
  struct FrameRange {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
  };
  /// Submits pass 0 for replaced frames, and pass 1 for the tiles whose rays they can have changed (dirty
  /// tiles). Precondition: notes_reach(), nothing is outstanding, the scene is that of the cast.
  Result<void> recast(const VolumeBindings& volume, FrameRange changed);

  /// Whether the depth map of follow() is that of the last volume under the same view.
  enum class History : std::uint8_t { kNone, kUsable };

  /// Submits passes 2 and 3 and the read-back, after the bands of pass 1 submitted before. The filter of the
  /// depth map is left out where its input and options have not changed.
  Result<void> light(const Scene& scene, const VolumeBindings& volume, History history);

  /// The same in pieces of about 4 ms: sets passes 2 and 3 up and submits nothing. Precondition: nothing is
  /// outstanding. Error: a pipeline that cannot be built.
  Result<void> begin_light(const Scene& wanted, const VolumeBindings& volume, History history);

  /// Submits the next piece; the last one has the read-back. Only the first piece reads the frames and what
  /// another view has drawn. Precondition: as begin_light().
  Result<void> light_next_piece();

  /// Between two pieces: lights by another scene, whose depth filter and camera are the same, with what is
  /// filtered so far. Precondition: nothing is outstanding, and the light was not begun
  /// (light_steps().begun()). Error: a pipeline that cannot be built.
  Result<void> change_light(const Scene& wanted, const VolumeBindings& volume);

  /// Whether passes 2 and 3 compute a part of the picture only; see take_cast().
  bool lights_a_part() const { return partly_; }

  /// The dispatches of begin_light(), and which of them were submitted.
  const LightSteps& light_steps() const { return light_steps_; }

  const SubmissionTimeline& timeline() const { return timeline_; }

  /// Number of submissions that the GPU has not finished.
  std::uint64_t outstanding() const { return timeline_.outstanding(*device_.gpu); }

  // As SubmissionTimeline::retry() and drop_held().
  Result<void> retry_held() { return timeline_.retry(); }
  void drop_held() { timeline_.drop_held(); }

  // The following functions read what the GPU wrote. Precondition: nothing is outstanding.

  /// The finished picture: height x width x RGBA, top row first.
  std::span<const std::uint8_t> picture() const { return memory_.read_back.mapped(); }

  /// Its depth map after pass 2's filter, mm, FANLIGHT_NO_SURFACE where there is none: height x width, top
  /// row first.
  std::span<const float> depth_mm() const {
    const auto bytes = memory_.read_back_depth.mapped();
    return {reinterpret_cast<const float*>(bytes.data()), bytes.size() / sizeof(float)};
  }

  /// When each stage ran; 0 for stages that the last submissions did not contain.
  std::array<StageSpan, kStages> stage_spans() const { return timestamps_.spans(*device_.gpu); }

  /// Milliseconds of each stage; 0 for stages that the last submissions did not contain. Of a view that
  /// pauses, the upload counts as part of the cast, and the read-back as part of the finish.
  std::array<double, kStages> stage_ms() const;

  /// The depth maps of pass 1 and of pass 2's filter, mm, FANLIGHT_NO_SURFACE where there is none, and the
  /// confidence: height x width, top row first. Blocks until they are copied, and allocates: for tests and
  /// one-shot rendering.
  Result<DepthMaps> read_depth();

 private:
  ViewRenderer(const PassDevice& device, const Config& config) : device_(device), config_(config) {}
  Result<void> create_commands();
  void set_tiles(const Scene& scene, const shaders::CastParameters& parameters);
  Result<void> submit_frames(const VolumeBindings& volume);
  void record_tables(VkCommandBuffer commands, AngleBuffer& angles);
  void record_before_rays(VkCommandBuffer commands, AngleBuffer& angles);
  void record_empty_space(VkCommandBuffer commands) const;
  void record_frame_steps(VkCommandBuffer commands) const;
  void record_slices(VkCommandBuffer commands) const;
  void record_dirty_tiles(VkCommandBuffer commands, const FrameStore& frames,
                          FrameRange frames_changed) const;
  Result<VkPipeline> confidence_pipeline(const PipelineKey& key, const Scene& scene, bool frames_gone,
                                         shaders::LightParameters& parameters) const;
  void choose_regions(const Scene& scene, shaders::LightParameters& parameters);
  LightStep on_tiles(VkPipeline pipeline, const PixelRect& part) const;
  Result<void> add_filter_steps(const LightKeys& keys, VkPipeline confidence);
  Result<void> add_light_steps(const LightKeys& keys, const Scene& scene);
  Result<void> submit_light(std::size_t end_step);
  void record_clear_min_depth(VkCommandBuffer commands) const;
  void record_light_steps(VkCommandBuffer commands, std::size_t end_step) const;
  void record_read_back(VkCommandBuffer commands) const;
  void record_maps_for_host(VkCommandBuffer commands) const;
  void bind_no_volume();
  void reset_times();
  void begin_piece(VkCommandBuffer commands, Stage stage);
  void end_piece(VkCommandBuffer commands) const;
  std::uint32_t pixels() const { return config_.size.width * config_.size.height; }
  // Of pixels. Pass 1 casts tiles of 8 x 8 rays, which are the same where each pixel has its ray.
  std::uint32_t tiles_across() const { return groups(config_.size.width, kTileSide); }
  std::uint32_t tiles_down() const { return groups(config_.size.height, kTileSide); }

  PassDevice device_;
  Config config_;
  std::optional<TransferFunction> transferred_;  // transfer function of the table on the GPU, and the step
  float transferred_step_mm_ = 0;                // that the table is for
  bool transfer_due_ = false;

  // Of the cast under way.
  double farthest_mm_ = 0;  // no surface lies deeper
  struct CastPipelines {    // null where CastKeys names none
    VkPipeline cast = VK_NULL_HANDLE;
    VkPipeline empty_space = VK_NULL_HANDLE;
    VkPipeline frame_steps = VK_NULL_HANDLE;
    VkPipeline slice = VK_NULL_HANDLE;
    VkPipeline cast_listed = VK_NULL_HANDLE;
    VkPipeline dirty_tiles = VK_NULL_HANDLE;
  };
  CastPipelines cast_pipelines_;
  bool confidence_known_ = false;  // of the depth map
  bool notes_reach_ = false;
  std::uint32_t cast_tiles_ = 0;  // of the whole picture
  std::uint32_t band_tiles_ = 0;  // of each band
  std::uint32_t next_tile_ = 0;   // first tile of the next band
  std::uint32_t segments_in_ray_ = 0;
  bool cast_since_light_ = false;
  bool preparing_ = false;               // pass 0 has begun
  std::optional<Scene::Filter> filter_;  // options of the filtered depth map

  // Of passes 2 and 3 under way.
  LightSteps light_steps_;
  LightRegions regions_;  // what they compute
  bool partly_ = false;   // that is a part of the picture
  PixelRect changed_;     // of what take_cast() copied, since the last picture
  /// What a picture's maps depend on besides pass 1, the filter's options and the last volume.
  struct MapsKey {
    shaders::LightParameters parameters{};  // without the part that is computed
    int diffusion_steps = 0;
    bool operator==(const MapsKey& other) const;
  };
  std::optional<MapsKey> maps_;                  // of the last picture; none while they are written
  MapsKey maps_due_;                             // what maps_ will be
  shaders::LightParameters filtered_{};          // of the last picture: its steady and confidence_counts
  const ViewBuffers* cast_to_copy_ = nullptr;    // of copy_cast(), until the first piece is submitted
  std::optional<Scene::Filter> filter_due_;      // what filter_ will be
  bool confidence_due_ = false;                  // what confidence_known_ will be
  std::array<double, kStages> light_step_ms_{};  // of one step of each stage; 0: not known
  std::size_t measured_light_steps_ = 0;         // how many steps of the light that is the time of

  // Of a view that pauses: sums of the pieces that are done, and the stage of the last one.
  std::array<double, kStages> done_ms_{};
  Stage piece_stage_ = Stage::kPrepare;

  ViewBuffers memory_;
  DescriptorSets descriptors_;
  CommandPoolHandle command_pool_;
  VkCommandBuffer cast_commands_ = VK_NULL_HANDLE;   // of the pool
  VkCommandBuffer light_commands_ = VK_NULL_HANDLE;  // of the pool
  GpuTimestamps timestamps_;
  SubmissionTimeline timeline_;
  TimelinePoint other_work_;  // on another timeline, whose results this view reads; null: there is none
};

}  // namespace fanlight
