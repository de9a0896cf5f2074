#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/picture.hpp"
#include "proto/volume.hpp"
#include "renderer/fan_table.hpp"
#include "renderer/gpu_memory.hpp"
#include "renderer/passes.hpp"

namespace fanlight {

/// Both depth maps of a picture; see RenderSlot::read_depth.
struct DepthMaps {
  std::vector<float> cast_mm;
  std::vector<float> smooth_mm;
};

/// Everything that one volume in flight needs on the GPU: its frames, its fan table, its depth map, its
/// picture, and the commands that make one from the other. Slots share nothing, so that two may be in flight.
/// Render thread only.
///
/// Life: empty -> load(volume) -> begin_cast(scene) -> cast_next_band() until cast_submitted() ->
/// light(scene) -> done, when nothing is outstanding -> and again from light() (a moved light), begin_cast()
/// (a moved camera) or load() (the next volume).
class RenderSlot {
 public:
  struct Config {
    PictureSize size;
    FanGeometry geometry;
    double first_angle_rad = 0;
    double last_angle_rad = 0;
    std::uint32_t frame_capacity = 0;
    std::uint64_t band_samples = 0;  ///< about the most samples that one submission of pass 1 may take
  };

  static Result<RenderSlot> create(const Gpu& gpu, const Passes& passes, const Config& config);

  /// Copies the volume's frames, in ascending order of angle, to where the GPU can fetch them; the volume may
  /// go when this returns. Precondition: nothing is outstanding.
  void load(const Volume& volume);

  /// Sets pass 1 up; nothing is submitted yet. Precondition: nothing is outstanding.
  void begin_cast(const Gpu& gpu, VkPipeline pass1, const Scene& scene);

  /// Submits the next band of pass 1, some tiles of the picture, the first together with the upload.
  /// Precondition: nothing is outstanding.
  Result<void> cast_next_band(const Gpu& gpu, const Passes& passes);
  bool cast_submitted() const { return next_tile_ == tiles_across() * tiles_down(); }

  /// Submits passes 2 and 3 and the read-back, after the bands of pass 1 submitted before.
  Result<void> light(const Gpu& gpu, const Passes& passes, const Scene& scene);

  bool loaded() const { return volume_.frames > 0; }
  const VolumeStamp& volume() const { return volume_; }

  /// The timeline reaches submissions() when all that was submitted is done.
  VkSemaphore timeline() const { return timeline_.get(); }
  std::uint64_t submissions() const { return submissions_; }

  /// How many submissions the GPU has not finished.
  std::uint64_t outstanding(const Gpu& gpu) const;

  // The following read what the GPU wrote: only when nothing is outstanding.

  /// The finished picture: height x width x RGBA, top row first.
  std::span<const std::uint8_t> picture() const { return read_back_.mapped(); }

  /// Milliseconds of each stage; 0 for those that the last submissions did not contain.
  std::array<double, kStages> stage_ms(const Gpu& gpu) const;

  /// The depth maps of pass 1 and of pass 2's filter, mm, FANLIGHT_NO_SURFACE where there is none: height x
  /// width, top row first. Waits for the copy and allocates: for tests and one-shot rendering.
  Result<DepthMaps> read_depth(const Gpu& gpu);

 private:
  explicit RenderSlot(const Config& config)
      : config_(config),
        table_(config.geometry, config.first_angle_rad, config.last_angle_rad, config.frame_capacity) {}
  Result<void> create_memory(const Gpu& gpu);
  Result<void> create_commands(const Gpu& gpu);
  Result<void> create_descriptors(const Gpu& gpu, const Passes& passes);
  void record_upload(VkCommandBuffer commands);
  // Pass 1 works on tiles of 8 x 8 pixels, numbered along the rows of tiles.
  std::uint32_t tiles_across() const { return (config_.size.width + 7) / 8; }
  std::uint32_t tiles_down() const { return (config_.size.height + 7) / 8; }
  Result<void> submit(VkQueue queue, VkCommandBuffer commands);
  void stamp_time(VkCommandBuffer commands, std::uint32_t query) const;

  Config config_;
  FanTable table_;
  VolumeStamp volume_;
  VolumeExtent extent_;
  bool frames_staged_ = false;  // loaded, but not yet part of a submitted upload
  bool table_staged_ = false;
  VkPipeline pass1_ = VK_NULL_HANDLE;  // of the cast under way
  std::uint32_t band_tiles_ = 0;       // of each band of that cast
  std::uint32_t next_tile_ = 0;        // the first of the next band
  bool cast_since_light_ = false;
  bool timed_cast_ = false;  // whether the last times are those of a pass 1 too

  GpuBuffer cast_parameters_;
  GpuBuffer light_parameters_;
  GpuBuffer staged_frames_;
  GpuBuffer staged_table_;
  GpuImage frames_;
  GpuImage fan_table_;
  GpuBuffer depth_;
  GpuBuffer volume_colour_;
  GpuBuffer row_sums_;
  GpuBuffer smooth_depth_;
  GpuBuffer lit_;
  GpuBuffer finished_;
  GpuBuffer read_back_;

  DescriptorPoolHandle descriptor_pool_;
  VkDescriptorSet descriptors_ = VK_NULL_HANDLE;  // the pool's
  CommandPoolHandle command_pool_;
  VkCommandBuffer cast_commands_ = VK_NULL_HANDLE;  // the pool's, as is the next
  VkCommandBuffer light_commands_ = VK_NULL_HANDLE;
  QueryPoolHandle times_;
  SemaphoreHandle timeline_;
  std::uint64_t submissions_ = 0;
};

}  // namespace fanlight
