// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "proto/base/result.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/scene.hpp"
#include "renderer/parameters/light_parameters.hpp"
#include "renderer/parameters/seam.hpp"
#include "renderer/parameters/steady_parameters.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "renderer/passes/cast_maps.hpp"
#include "renderer/passes/cast_pass.hpp"
#include "renderer/passes/light_here.hpp"
#include "renderer/passes/light_memory.hpp"
#include "renderer/passes/light_regions.hpp"
#include "renderer/passes/light_steps.hpp"
#include "renderer/passes/pass_recorder.hpp"
#include "renderer/passes/pixel_rect.hpp"

namespace fanlight {

/// Passes 2 and 3 of one view: the depth map of a CastPass is filtered and lit, and the picture smoothed.
/// Does not read the volume.
///
/// Owns its maps and its PassRecorder. Render thread only.
///
/// Life: create() -> read(), copy() or copy_by_host() of a cast -> begin(scene) -> submit_next() until
/// steps().submitted() -> done, when nothing is outstanding -> and again from begin() (a changed light), or
/// from another cast.
class LightPass {
 public:
  struct Config {
    PictureSize largest;  ///< of any scene
    /// Memory for copies of a cast's maps: none, copies by this device, or by the host, also from another
    /// device. With the last, passes 2 and 3 compute only what has changed since the last picture, where that
    /// is less than half of it and `skipping` is on.
    enum class Copies : std::uint8_t { kNone, kOnDevice, kByHost } copies = Copies::kNone;
    Skipping skipping = Skipping::kOn;
    bool pauses = false;  ///< as PassRecorder::Config
    /// They run all but the temporal filter of several volumes and the seam; then the pass's device is this
    /// processor, and pieces are submitted one by one. Null: the GPU does.
    RenderWorkers* workers = nullptr;
  };

  LightPass() = default;
  /// Allocates all memory, on the device whose GPU and pipelines it uses from then on. Error: no memory on
  /// the GPU.
  static Result<LightPass> create(const PassDevice& device, const Config& config);

  // Sets the depth map that the next begin() filters. A map that was copied already is not copied again.
  // Precondition: nothing of this pass is outstanding.

  /// That of a cast of the same device, read where it is. The cast may not begin again before all steps of
  /// this pass are done.
  void read(const CastPass& cast);
  /// A copy of it, made by the next submission: it may be cast again once that is done. Needs kOnDevice.
  void copy(const CastPass& cast);
  /// A copy of it, made now, also from another device. Needs kByHost. Precondition:
  /// CastPass::maps_are_written().
  void copy_by_host(const CastPass& cast);

  /// Of the maps of the last begin().
  PictureSize size() const { return size_; }
  PictureSize largest() const { return config_.largest; }

  /// Sets the temporal filter's input: steady() of the other slot, or a copy of it. For a Seam this pass
  /// copies its own map there before it writes the next one. Precondition as above.
  void follow(const GpuBuffer& steady);
  /// Sets whose submissions read steady(): the processor does not write the map while some are outstanding. A
  /// queue keeps that order by itself. `reader` must outlive this object.
  void set_reader(const SubmissionTimeline& reader) { reader_ = &reader; }
  /// The temporally filtered depth map, two floats a pixel: the depth in mm and the number of volumes in it.
  /// Mapped with kByHost, and where the processor writes it.
  const GpuBuffer& steady() const { return memory_.steady; }

  /// The map of follow(); absent where it is not one of another volume, found as this one is.
  using Earlier = std::optional<EarlierMap>;

  /// Sets passes 2 and 3 up for this effective_scene() of the cast, and submits nothing. The filter of the
  /// depth map is left out where its input and options have not changed. Precondition: nothing is
  /// outstanding. Error: a pipeline that cannot be built.
  /// `seam`: of a cast whose frames replace those of the last sweep one by one; null: of others. Its earlier
  /// map is steady() of this pass.
  Result<void> begin(const Scene& scene, const Earlier& earlier, const Seam* seam = nullptr);

  /// Submits the next piece, about 4 ms of work; the first one has all that reads the map of follow(), which
  /// the GPU may write again then, and the processor when it is done. The last one has the read-back. A piece
  /// that the processor runs is done at the return. Precondition: as begin().
  Result<void> submit_next();
  /// Submits all that is left. Precondition: the GPU does all of it.
  Result<void> submit_all() { return submit(steps_.count()); }

  /// Between two pieces: lights by another effective_scene(), whose depth filter and camera are the same,
  /// with what is filtered so far. Precondition: nothing is outstanding, and the light was not begun
  /// (steps().begun()). Error: a pipeline that cannot be built.
  Result<void> change(const Scene& scene);

  /// The dispatches of begin(), and which of them were submitted.
  const LightSteps& steps() const { return steps_; }
  /// Whether begin() computes a part of the picture only.
  bool lights_a_part() const { return partly_; }
  /// Whether it blends at the seam of a rolling sweep.
  bool blends() const { return maps_due_.temporal == FANLIGHT_TEMPORAL_SEAM; }
  /// Whether the picture of the last begin() is the first of its cast.
  bool is_first_of_cast() const { return is_first_of_cast_; }

  /// Whether the processor writes the maps (Config::workers).
  bool lights_here() const { return here_.on(); }

  /// As those of PassRecorder, with what the processor did.
  std::array<StageSpan, kStages> stage_spans() const;
  std::array<double, kStages> stage_ms() const;

  const PassRecorder& recorder() const { return recorder_; }
  PassRecorder& recorder() { return recorder_; }

  // What the GPU wrote. Precondition: nothing is outstanding.

  /// Copies the finished picture with its stamp, to which it adds what it knows of the surface. The surface
  /// is copied only where `to` has another one. Allocates nothing where `to` has been as large before.
  void read_picture(const PictureStamp& stamp, Picture& to) const;

  /// The picture's depth map after pass 2's filter, mm, FANLIGHT_NO_SURFACE where there is none: height x
  /// width, top row first.
  std::span<const float> depth_mm() const {
    const auto bytes = memory_.read_back_depth.mapped();
    return {reinterpret_cast<const float*>(bytes.data()), pixels()};
  }

 private:
  explicit LightPass(const Config& config) : config_(config), here_(config.workers) {}
  enum class Change : std::uint8_t { kNone, kWeights, kCast };
  Change take(const CastPass& cast);
  void name_maps(const CastMaps& maps);
  void take_size(PictureSize size);
  void learn_step_times();
  double surface_share() const;
  double uncertain_share() const;
  double steady_share() const;
  double mean_volumes() const;
  std::span<const std::uint8_t> colours() const;
  bool in_pieces() const { return config_.pauses || config_.copies == Config::Copies::kByHost || here_.on(); }
  void choose_regions(const Scene& scene, int temporal, shaders::LightParameters& parameters);
  PixelRect changed_by_blending(int seam_frames) const;
  void note_changed_part();
  LightStep on_tiles(VkPipeline pipeline, const PixelRect& part) const;
  int take_earlier(const Scene& scene, const Earlier& earlier, const Seam* seam) const;
  Result<void> add_steady_steps();
  Result<void> add_filter_steps(const LightKeys& keys);
  Result<void> add_light_steps(const LightKeys& keys, const Scene& scene);
  bool is_here(std::size_t step) const { return step < steps_.count() && steps_[step].here.has_value(); }
  void note_light_steps();
  Result<void> submit(std::size_t end_step);
  Result<void> light_here(std::size_t end_step);
  void note_submitted(std::size_t end_step);
  void record_map_before(VkCommandBuffer commands) const;
  void record_clear_totals(VkCommandBuffer commands) const;
  void record_steps(VkCommandBuffer commands, std::size_t end_step) const;
  void record_read_back(VkCommandBuffer commands) const;
  std::size_t pixels() const { return size_.pixels(); }

  Config config_;

  // The input.
  struct Input {
    VkBuffer depth = VK_NULL_HANDLE;  // identifies the CastPass
    std::uint64_t number = 0;         // CastPass::number()
    bool weighted = false;            // CastPass::weighted()
  };
  Input input_;
  double farthest_mm_ = 0;
  VkBuffer named_maps_ = VK_NULL_HANDLE;     // depth of the maps that the descriptors name
  VkBuffer named_colours_ = VK_NULL_HANDLE;  // colours of the same maps
  const CastMaps* maps_to_copy_ = nullptr;   // until the next submission
  TimelinePoint written_;                    // reached when the GPU has written the maps
  bool is_new_cast_ = false;                 // no picture of it was submitted
  bool is_new_input_ = false;                // no picture of it, or of its weights, was submitted
  // The processor lights, and the GPU may not have written or copied the maps yet.
  bool awaits_maps_ = false;
  bool is_first_of_cast_ = false;
  PixelRect changed_;  // of what copy_by_host() copied, since the last picture

  // Of the rolling sweep. The map of steady() has this many of its frames, and the ones that change are due.
  VkBuffer followed_ = VK_NULL_HANDLE;               // of follow()
  std::size_t map_before_pixels_ = 0;                // of steady()
  int filtered_temporal_ = FANLIGHT_TEMPORAL_ALONE;  // how steady() was made
  std::uint64_t new_frames_ = 0;
  std::uint64_t new_frames_due_ = 0;
  bool motor_turned_ = false;  // among the frames that are blended
  // What the last pictures changed, newest first, while their frames are blended.
  struct ChangedPart {
    PixelRect part;
    std::uint64_t new_frames = 0;
  };
  std::array<ChangedPart, FANLIGHT_MOST_SEAM_FRAMES + 1> changed_parts_{};

  // Of the picture under way.
  PictureSize size_;
  LightSteps steps_;
  LightRegions regions_;          // what they compute
  bool partly_ = false;           // that is a part of the picture
  std::uint64_t surface_id_ = 0;  // PictureStamp::surface_id
  /// What a picture's maps depend on besides pass 1, the filter's options and the last volume.
  struct MapsKey {
    shaders::LightParameters parameters{};  // without the part that is computed
    int diffusion_steps = 0;
    int temporal = FANLIGHT_TEMPORAL_ALONE;
    bool operator==(const MapsKey& other) const;
  };
  std::optional<MapsKey> maps_;              // of the last picture; none while they are written
  MapsKey maps_due_;                         // what maps_ will be
  shaders::LightParameters filtered_{};      // of the last picture: its confidence_counts
  std::optional<Scene::Filter> filter_;      // options of the filtered depth map
  std::optional<Scene::Filter> filter_due_;  // what filter_ will be
  std::size_t steady_steps_ = 0;             // of steps_, those that read the map of follow()
  std::array<double, kStages> step_ms_{};    // of one step of each stage; 0: not known
  std::size_t measured_light_steps_ = 0;     // how many steps of the light that is the time of

  CastMaps copies_;
  LightMemory memory_;
  LightHere here_;
  const SubmissionTimeline* reader_ = nullptr;  // of another LightPass
  PassRecorder recorder_;
};

}  // namespace fanlight
