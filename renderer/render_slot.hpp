#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "proto/frame_feed.hpp"
#include "proto/picture.hpp"
#include "proto/volume.hpp"
#include "renderer/angle_table.hpp"
#include "renderer/descriptor_sets.hpp"
#include "renderer/frame_store.hpp"
#include "renderer/passes.hpp"
#include "renderer/slot_memory.hpp"
#include "renderer/stage_clock.hpp"
#include "renderer/view.hpp"

namespace fanlight {

/// What a picture knows of depths; see RenderSlot::read_depth.
struct DepthMaps {
  std::vector<float> cast_mm;  ///< of pass 1
  /// Edge contrast over the noise beside it, 0 without a surface; empty where the filter does not weigh by
  /// it.
  std::vector<float> confidence;
  std::vector<float> smooth_mm;  ///< after pass 2's filter
  /// Of the segments of all tiles' rays, those that rays had to sample; 1 where pass 1 passes over nothing.
  double sampled_share = 1;
};

/// Everything that one volume in flight needs on the GPU: its frames, its angle table, its depth map, its
/// picture, and the commands that make one from the other. Two may be in flight; they share nothing but that
/// the filter of each reads the last depth map of the other, on the one queue that runs both. Render thread
/// only.
///
/// Life: empty -> load(volume) -> begin_cast(scene) -> cast_next_band() until cast_submitted() ->
/// light(scene) -> done, when nothing is outstanding -> and again from light() (a moved light), begin_cast()
/// (a moved camera) or load() (the next volume).
class RenderSlot {
 public:
  struct Config {
    PictureSize size;
    FanGeometry geometry;  ///< that room is made for at once
    double first_angle_rad = 0;
    double last_angle_rad = 0;
    std::uint32_t frame_capacity = 0;
    std::uint32_t usual_frames = 0;  ///< that room is made for at once
    std::uint64_t band_samples = 0;  ///< about the most samples that one submission of pass 1 may take
    Skipping skipping = Skipping::kOn;
    Sampling sampling = Sampling::kTexture;
  };

  static Result<RenderSlot> create(const Gpu& gpu, const Passes& passes, const Config& config);

  /// Takes the memory and builds the pipelines that casting this scene will need, so that the first volume
  /// need not. Before the first volume. Error: a pipeline that cannot be built.
  Result<void> prepare(const Gpu& gpu, Passes& passes, const Scene& scene);

  /// The slot of the volumes before and after this one's, whose depth maps this one's are drawn towards.
  /// Once, before the first volume.
  void follow(const Gpu& gpu, const RenderSlot& other);

  /// Copies the frames of the volume that are not there yet, in ascending order of angle, to where the GPU
  /// can fetch them; the volume may go when this returns. Where its columns or rows are not those of the
  /// last, or its frames more than there is room for, the memory for frames is made anew, the old given back
  /// first. Precondition: nothing is outstanding. Errors as FrameStore::create; then light() still does what
  /// it did, but only a load() that succeeds may be followed by begin_cast().
  Result<void> load(const Gpu& gpu, const Volume& volume);

  /// Puts a frame of the volume to come in its place of `frames`, ahead of the others. What was cast before
  /// can still be lit. Nothing where it does not fit. Precondition: nothing is outstanding.
  void stage(const FanGeometry& geometry, std::uint32_t place, std::uint32_t frames, std::uint64_t arrival,
             std::span<const std::uint8_t> pixels);

  /// Submits pass 0 for frames that are staged ahead; false where there are none to prepare before their
  /// volume is whole. Precondition: nothing is outstanding.
  Result<bool> prepare_ahead(const Gpu& gpu, Passes& passes, const Scene::Speckle& options);

  /// Replaces one frame of the volume that was cast by a newer one, at an angle between those beside it, and
  /// says so in volume(). False, and nothing is done, where it does not fit. Precondition: nothing is
  /// outstanding.
  bool replace(const FedFrame& frame, std::uint32_t place, double angle_rad);

  /// Whether it has room for the volume, and for no larger frames.
  bool suits(const Volume& volume) const { return frames_.suits(volume); }

  /// The volume that the frames of replace() made up is whole: takes what is missing of it, its angles and
  /// its stamp. Precondition: suits(volume). Error as load().
  Result<void> complete(const Gpu& gpu, const Volume& volume);

  /// Whether the cast is not of the frames that are there, and whether recast() can mend it: else
  /// begin_cast() must.
  bool changed() const { return changed_.has_value() || changed_beyond_; }
  bool can_recast() const { return changed_.has_value() && !changed_beyond_ && notes_reach_; }

  /// Submits passes 0 and 1 for the frames that were replaced, of pass 1 the tiles whose rays they can have
  /// changed; light() comes next. Precondition: can_recast(), nothing is outstanding, the scene is that of
  /// the cast.
  Result<void> recast(const Gpu& gpu, Passes& passes, const Scene& scene);

  /// Sets passes 0 and 1 up; nothing is submitted yet. Also gives up a cast under way. Precondition: nothing
  /// is outstanding. Error: a pipeline that cannot be built.
  Result<void> begin_cast(const Gpu& gpu, Passes& passes, const Scene& scene);
  /// Of the last volume or frames, ascending.
  std::span<const double> angles_rad() const { return angles_rad_; }

  /// Submits what is due next: a piece of pass 0, some frames, the last one with the upload; or a band of
  /// pass 1, some tiles of the picture. Precondition: nothing is outstanding.
  Result<void> cast_next_band(const Gpu& gpu, const Passes& passes);
  bool cast_submitted() const { return frames_.done() && next_tile_ == cast_tiles_; }

  /// Whether the other slot's depth map is that of the last volume under the same view.
  enum class Past : std::uint8_t { kNone, kKnown };

  /// Submits passes 2 and 3 and the read-back, after the bands of pass 1 submitted before. The filter of the
  /// depth map is left out where it would do again what it did.
  Result<void> light(const Gpu& gpu, Passes& passes, const Scene& scene, Past past);

  /// Whether the cast under way leaves out the speckle filter asked for; see FrameStore::begin.
  bool filter_left_out() const { return frames_.filter_left_out(); }

  bool loaded() const { return volume_.frames > 0; }
  const VolumeStamp& volume() const { return volume_; }

  /// The timeline reaches submissions() when all that was submitted is done.
  VkSemaphore timeline() const { return timeline_.get(); }
  std::uint64_t submissions() const { return submissions_; }

  /// When the last of them was made (fanlight::now_ns).
  std::int64_t submitted_ns() const { return submitted_ns_; }

  /// How many submissions the GPU has not finished.
  std::uint64_t outstanding(const Gpu& gpu) const;

  // The following read what the GPU wrote: only when nothing is outstanding.

  /// The finished picture: height x width x RGBA, top row first.
  std::span<const std::uint8_t> picture() const { return memory_.read_back.mapped(); }

  /// Its depth map after pass 2's filter, mm, FANLIGHT_NO_SURFACE where there is none: height x width, top row
  /// first.
  std::span<const float> depth_mm() const {
    const auto bytes = memory_.read_back_depth.mapped();
    return {reinterpret_cast<const float*>(bytes.data()), bytes.size() / sizeof(float)};
  }

  /// When each stage ran; nothing for those that the last submissions did not contain.
  std::array<StageSpan, kStages> stage_spans(const Gpu& gpu) const { return clock_.spans(gpu); }

  /// Milliseconds of each stage; 0 for those that the last submissions did not contain.
  std::array<double, kStages> stage_ms(const Gpu& gpu) const { return clock_.ms(gpu); }

  /// The depth maps of pass 1 and of pass 2's filter, mm, FANLIGHT_NO_SURFACE where there is none, and the
  /// confidence: height x width, top row first. Waits for the copy and allocates: for tests and one-shot
  /// rendering.
  Result<DepthMaps> read_depth(const Gpu& gpu);

 private:
  explicit RenderSlot(const Config& config)
      : config_(config), table_(config.first_angle_rad, config.last_angle_rad, config.frame_capacity) {
    angles_rad_.reserve(config.frame_capacity);
  }
  Result<void> create_frames(const Gpu& gpu, const FanGeometry& geometry, std::uint32_t frames);
  Result<void> replace_frames(const Gpu& gpu, const Volume& volume);
  Result<void> create_commands(const Gpu& gpu);
  Result<void> create_descriptors(const Gpu& gpu, const Passes& passes);
  Result<void> submit_frames(const Gpu& gpu, const Passes& passes);
  Result<void> find_cast_pipelines(Passes& passes, const Scene& scene);
  void record_tables(VkCommandBuffer commands);
  void record_before_rays(VkCommandBuffer commands);
  void change(std::uint32_t place);
  void record_segments(VkCommandBuffer commands) const;
  void record_slices(VkCommandBuffer commands) const;
  void record_changed_tiles(VkCommandBuffer commands, const Passes& passes, VkPipeline changed) const;
  Result<void> record_depth_filter(VkCommandBuffer commands, Passes& passes, const Scene& scene);
  void record_finish(VkCommandBuffer commands, const Passes& passes, const Scene& scene) const;
  void place_angles();
  void write_frame_descriptors(const Gpu& gpu) const;
  std::uint32_t pixels() const { return config_.size.width * config_.size.height; }
  // Passes 2 and 3 work on tiles of 8 x 8 pixels, numbered along the rows of tiles; pass 1 on tiles of 8 x 8
  // rays, which are the same where each pixel has its ray.
  std::uint32_t tiles_across() const { return (config_.size.width + 7) / 8; }
  std::uint32_t tiles_down() const { return (config_.size.height + 7) / 8; }
  Result<void> submit(VkQueue queue, VkCommandBuffer commands);

  Config config_;
  AngleTable table_;
  std::vector<double> angles_rad_;  // of the frames, ascending
  // By place, frames that are not those of the cast; and whether more changed than frames within the fan.
  struct Places {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
  };
  std::optional<Places> changed_;
  bool changed_beyond_ = false;
  bool notes_reach_ = false;  // the cast noted how far its rays looked
  FanGeometry geometry_;      // of the volume, as are the next two
  VolumeStamp volume_;
  VolumeExtent extent_;
  std::optional<TransferFunction> transferred_;  // of the table on the GPU, and for samples so far apart
  float transferred_step_mm_ = 0;
  bool transfer_due_ = false;
  bool angles_due_ = false;

  // Of the cast under way.
  double farthest_mm_ = 0;  // no surface lies deeper
  VkPipeline cast_pipeline_ = VK_NULL_HANDLE;
  VkPipeline slice_pipeline_ = VK_NULL_HANDLE;       // null where the mode shows no planes
  VkPipeline segments_pipeline_ = VK_NULL_HANDLE;    // null where rays pass over nothing
  VkPipeline confidence_pipeline_ = VK_NULL_HANDLE;  // null where nothing counts by it
  bool confidence_known_ = false;                    // of the depth map
  bool frames_gone_ = false;                         // others were staged since the cast
  std::uint32_t cast_tiles_ = 0;                     // of the whole picture
  std::uint32_t band_tiles_ = 0;                     // of each band
  std::uint32_t next_tile_ = 0;                      // the first of the next band
  std::uint32_t segments_in_ray_ = 0;
  bool cast_since_light_ = false;
  bool preparing_ = false;               // pass 0 has begun
  std::optional<Scene::Filter> filter_;  // what the filtered depth map was made with

  SlotMemory memory_;
  FrameStore frames_;
  DescriptorSets descriptors_;
  CommandPoolHandle command_pool_;
  VkCommandBuffer cast_commands_ = VK_NULL_HANDLE;  // the pool's, as is the next
  VkCommandBuffer light_commands_ = VK_NULL_HANDLE;
  StageClock clock_;
  SemaphoreHandle timeline_;
  std::uint64_t submissions_ = 0;
  std::int64_t submitted_ns_ = 0;
};

}  // namespace fanlight
