#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/picture.hpp"
#include "renderer/angle_buffer.hpp"
#include "renderer/angle_table.hpp"
#include "renderer/descriptor_sets.hpp"
#include "renderer/frame_store.hpp"
#include "renderer/passes.hpp"
#include "renderer/slot_memory.hpp"
#include "renderer/stage_clock.hpp"
#include "renderer/view.hpp"

namespace fanlight {

/// What a picture knows of depths; see VolumeView::read_depth.
struct DepthMaps {
  std::vector<float> cast_mm;  ///< of pass 1
  /// Edge contrast over the noise beside it, 0 without a surface; empty where the filter does not weigh by
  /// it.
  std::vector<float> confidence;
  std::vector<float> smooth_mm;  ///< after pass 2's filter
  /// Of the segments of all tiles' rays, those that rays had to sample; 1 where pass 1 passes over nothing.
  double sampled_share = 1;
};

/// Of a volume on the GPU, what its views read.
struct SeenVolume {
  FrameStore& frames;
  AngleBuffer& angles;
  const AngleTable& table;
  const FanGeometry& geometry;
  const VolumeExtent& extent;
  bool frames_gone = false;  ///< others were staged since the cast
  /// What wrote all of it: is done when the timeline has come to this value.
  VkSemaphore timeline = VK_NULL_HANDLE;
  std::uint64_t submissions = 0;
};

/// One view of a volume: its depth map, its picture, and the commands of the passes that make one from the
/// other. Render thread only.
///
/// Life: made -> see(volume) -> begin_cast(scene) -> cast_next_band() until cast_submitted() -> light(scene)
/// -> done, when nothing is outstanding -> and again from light() (a moved light) or begin_cast() (a moved
/// camera, the next volume). Or with another view's depth map: share_cast(other) -> light(scene).
class VolumeView {
 public:
  struct Config {
    PictureSize size;
    std::uint64_t band_samples = 0;  ///< about the most samples that one submission of pass 1 may take
    Skipping skipping = Skipping::kOn;
  };

  VolumeView() = default;
  static Result<VolumeView> create(const Gpu& gpu, const Passes& passes, const Config& config);

  /// The volume that it will cast, also where its buffers have become others. Precondition for this and the
  /// next two: nothing is outstanding.
  void see(const Gpu& gpu, const SeenVolume& volume);

  /// The view of the volumes before and after this one's, whose depth maps this one's are drawn towards.
  void follow(const Gpu& gpu, const VolumeView& other);

  /// Goes on from what another view has cast, whose memory must stay as it is while anything here is
  /// outstanding. `volume` is the other's, as in see().
  void share_cast(const Gpu& gpu, const VolumeView& other, const SeenVolume& volume);

  /// Builds the pipelines that casting this scene will need. Error: one that cannot be built.
  Result<void> find_cast_pipelines(Passes& passes, const Scene& scene, FrameKind kind);

  /// Sets pass 1 up; nothing is submitted yet. Also gives up a cast under way. Precondition: nothing is
  /// outstanding. Error: a pipeline that cannot be built.
  Result<void> begin_cast(const Gpu& gpu, Passes& passes, const Scene& scene, const SeenVolume& volume);

  /// Submits what is due next: a piece of pass 0, some frames, the last one with the upload; or a band of
  /// pass 1, some tiles of the picture. Precondition: nothing is outstanding.
  Result<void> cast_next_band(const Gpu& gpu, const Passes& passes, const SeenVolume& volume);

  /// Whether all of pass 1 was.
  bool cast_submitted() const { return next_tile_ == cast_tiles_; }

  /// Submits one piece of pass 0 by itself. Precondition: nothing is outstanding, and the frames are not
  /// done.
  Result<void> prepare_ahead(const Gpu& gpu, const Passes& passes, const SeenVolume& volume);

  /// Whether the cast noted how far its rays looked, so that recast() can mend it.
  bool notes_reach() const { return notes_reach_; }

  /// Submits passes 0 and 1 for frames that were replaced, by their first and last place: of pass 1 the tiles
  /// whose rays they can have changed. Precondition: notes_reach(), nothing is outstanding, the scene is that
  /// of the cast.
  struct Places {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
  };
  Result<void> recast(const Gpu& gpu, Passes& passes, const Scene& scene, const SeenVolume& volume,
                      Places changed);

  /// Whether the depth map of follow() is that of the last volume under the same view.
  enum class Past : std::uint8_t { kNone, kKnown };

  /// Submits passes 2 and 3 and the read-back, after the bands of pass 1 submitted before. The filter of the
  /// depth map is left out where it would do again what it did.
  Result<void> light(const Gpu& gpu, Passes& passes, const Scene& scene, const SeenVolume& volume, Past past);

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

  /// Its depth map after pass 2's filter, mm, FANLIGHT_NO_SURFACE where there is none: height x width, top
  /// row first.
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
  explicit VolumeView(const Config& config) : config_(config) {}
  Result<void> create_commands(const Gpu& gpu);
  Result<void> submit_frames(const Gpu& gpu, const Passes& passes, const SeenVolume& volume);
  void record_tables(VkCommandBuffer commands, AngleBuffer& angles);
  void record_before_rays(VkCommandBuffer commands, AngleBuffer& angles);
  void record_segments(VkCommandBuffer commands) const;
  void record_slices(VkCommandBuffer commands) const;
  void record_changed_tiles(VkCommandBuffer commands, const Passes& passes, VkPipeline changed,
                            const FrameStore& frames, Places places) const;
  Result<void> record_depth_filter(VkCommandBuffer commands, Passes& passes, const Scene& scene);
  void record_finish(VkCommandBuffer commands, const Passes& passes, const Scene& scene) const;
  std::uint32_t pixels() const { return config_.size.width * config_.size.height; }
  // Passes 2 and 3 work on tiles of 8 x 8 pixels, numbered along the rows of tiles; pass 1 on tiles of 8 x 8
  // rays, which are the same where each pixel has its ray.
  std::uint32_t tiles_across() const { return (config_.size.width + 7) / 8; }
  std::uint32_t tiles_down() const { return (config_.size.height + 7) / 8; }
  void wait_for(const SeenVolume& volume);
  Result<void> submit(VkQueue queue, VkCommandBuffer commands);

  Config config_;
  std::optional<TransferFunction> transferred_;  // of the table on the GPU, and for samples so far apart
  float transferred_step_mm_ = 0;
  bool transfer_due_ = false;

  // Of the cast under way.
  double farthest_mm_ = 0;  // no surface lies deeper
  VkPipeline cast_pipeline_ = VK_NULL_HANDLE;
  VkPipeline slice_pipeline_ = VK_NULL_HANDLE;       // null where the mode shows no planes
  VkPipeline segments_pipeline_ = VK_NULL_HANDLE;    // null where rays pass over nothing
  VkPipeline confidence_pipeline_ = VK_NULL_HANDLE;  // null where nothing counts by it
  bool confidence_known_ = false;                    // of the depth map
  bool notes_reach_ = false;
  std::uint32_t cast_tiles_ = 0;  // of the whole picture
  std::uint32_t band_tiles_ = 0;  // of each band
  std::uint32_t next_tile_ = 0;   // the first of the next band
  std::uint32_t segments_in_ray_ = 0;
  bool cast_since_light_ = false;
  bool preparing_ = false;               // pass 0 has begun
  std::optional<Scene::Filter> filter_;  // what the filtered depth map was made with

  SlotMemory memory_;
  DescriptorSets descriptors_;
  CommandPoolHandle command_pool_;
  VkCommandBuffer cast_commands_ = VK_NULL_HANDLE;  // the pool's, as is the next
  VkCommandBuffer light_commands_ = VK_NULL_HANDLE;
  StageClock clock_;
  SemaphoreHandle timeline_;
  VkSemaphore others_timeline_ = VK_NULL_HANDLE;  // whose work this one's reads the results of; null: its own
  std::uint64_t others_submissions_ = 0;
  std::uint64_t submissions_ = 0;
  std::int64_t submitted_ns_ = 0;
};

}  // namespace fanlight
