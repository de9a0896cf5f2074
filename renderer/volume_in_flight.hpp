// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "proto/exchange/frame_queue.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/volume.hpp"
#include "renderer/parameters/angle_table.hpp"
#include "renderer/parameters/effective_scene.hpp"
#include "renderer/passes/cast_pass.hpp"
#include "renderer/passes/light_pass.hpp"
#include "renderer/pipelines/pipelines.hpp"
#include "renderer/volume/angle_buffer.hpp"
#include "renderer/volume/frame_store.hpp"

namespace fanlight {

/// All GPU resources of one volume in flight. Owns its frames, its angle table, and the main view of it: a
/// CastPass and a LightPass. Two volumes may be in flight. They share one thing: the temporal filter of each
/// reads the last depth map of the other, on the queue that runs both filters. Where frames are replaced one
/// by one, that map holds the slot's own last one. Render thread only.
///
/// Where one GPU runs all passes, the LightPass reads the depth map where it is. Else the host copies the
/// map: to the LightPass's own device (decision renderer/010), or where the processor runs passes 1 to 3
/// (018).
///
/// Life: empty -> load(volume) -> begin_cast(scene) -> cast_next_band() until cast_submitted() ->
/// light(scene) -> done, when nothing is outstanding -> and again from light() (a changed light),
/// begin_cast() (a changed view) or load() (the next volume). Where frames are replaced one by one: replace()
/// -> recast() or begin_cast() -> cast_next_band() until cast_submitted() -> light(), and complete() with the
/// whole volume.
class VolumeInFlight {
 public:
  struct Config {
    PictureSize size;      ///< of scenes that have none
    PictureSize largest;   ///< of any scene
    FanGeometry geometry;  ///< memory for such frames is allocated in create()
    double first_angle_rad = 0;
    double last_angle_rad = 0;
    std::uint32_t frame_capacity = 0;
    std::uint32_t usual_frames = 0;  ///< memory for this number of frames is allocated in create()
    std::uint64_t band_samples = 0;  ///< approximate limit of samples in one submission of pass 1
    Skipping skipping = Skipping::kOn;
    Counting counting = Counting::kOff;
    Sampling sampling = Sampling::kTexture;
    RenderWorkers* workers = nullptr;      ///< as FrameStore::Config
    RenderWorkers* ray_workers = nullptr;  ///< as CastPass::Config
  };

  /// `light`: for passes 2 and 3; null: they run on `device` too. Precondition: null where the processor
  /// casts the rays.
  static Result<VolumeInFlight> create(const PassDevice& device, const Config& config,
                                       const PassDevice* light);

  /// Allocates the memory of pass 0 and builds the pipelines that casting this scene needs, ahead of the
  /// first volume. Error: a pipeline that cannot be built.
  Result<void> prepare(const Scene& scene);

  /// Sets the slot of the volumes before and after this one's, whose depth map the temporal filter reads.
  /// Once, before the first volume.
  void follow(const VolumeInFlight& other);

  /// Copies those frames of the volume that are not staged yet, in ascending order of angle, to memory that
  /// the GPU reads; the volume is not needed afterwards. Where its columns or rows differ from the last
  /// volume's, or it has more frames than the memory holds, the frames' memory is freed and allocated again.
  /// Precondition: nothing is outstanding. Errors as FrameStore::create; then light() still works on the last
  /// depth map, but begin_cast() needs a load() that succeeds.
  /// `levels`: for what scenes leave to the data; `near_tissue`: for those that remove it.
  Result<void> load(const Volume& volume, const EchoLevels& levels, const NearTissueSearch& near_tissue);

  /// Copies a frame of the next volume, which is estimated to have `frames` frames, ahead of the others. The
  /// last depth map can still be lit. Does nothing where the frame does not fit. Precondition: nothing is
  /// outstanding.
  void stage(const FanGeometry& geometry, std::uint32_t frame_index, std::uint32_t frames,
             std::uint64_t commit_number, std::span<const std::uint8_t> pixels);

  /// Runs or submits a piece of pass 0 for frames that are staged ahead; false where there are none, or where
  /// the filter needs their neighbours first. `levels`: those that load() will get. Precondition: nothing is
  /// outstanding.
  Result<bool> prepare_ahead(const Scene& scene, const EchoLevels& levels);

  /// Whether frames of the next volume were staged since the cast.
  bool frames_staged() const { return frames_gone_; }

  /// Replaces one frame of the cast volume by a newer one, at an angle between its neighbours' angles, and
  /// updates volume(). Returns false and does nothing where the frame does not fit. Precondition: nothing is
  /// outstanding.
  bool replace(const QueuedFrame& frame, std::uint32_t frame_index, double angle_rad);

  /// Blends nothing until the next frame is replaced.
  void end_seam() { new_frames_ = {}; }

  /// Whether the allocated memory has room for the volume, and for no larger frames.
  bool suits(const Volume& volume) const { return frames_.suits(volume); }

  /// Completes the volume that replace() assembled frame by frame: takes its missing frames, its angles and
  /// its stamp. Precondition: suits(volume). Error as load(). Other levels or other near tissue need a
  /// begin_cast().
  Result<void> complete(const Volume& volume, const EchoLevels& levels, const NearTissueSearch& near_tissue);

  /// Whether the frames changed since the cast, and whether recast() suffices; otherwise begin_cast() is
  /// needed.
  bool changed() const { return changed_.has_value() || changed_beyond_; }
  bool can_recast() const { return changed_.has_value() && !changed_beyond_ && cast_.notes_reach(); }

  /// Submits passes 0 and 1 for the replaced frames; pass 1 casts the dirty tiles only. cast_next_band()
  /// until cast_submitted(), then light(), come next.
  /// Precondition: can_recast(), nothing is outstanding, the scene is that of the cast.
  Result<void> recast(const Scene& scene);

  /// Sets passes 0 and 1 up and gives up a cast under way; submits nothing. Precondition: nothing is
  /// outstanding. Error: a pipeline that cannot be built.
  Result<void> begin_cast(const Scene& scene);

  /// Angles of the last volume's frames, with replaced frames, ascending.
  std::span<const double> angles_rad() const { return angles_rad_; }
  /// Index of the frame at the nearest angle. Precondition: loaded().
  std::uint32_t nearest_frame_index(double angle_rad) const;

  // As the functions of CastPass. Precondition: nothing is outstanding.
  Result<void> cast_next_band() { return cast_.submit_next(bindings()); }
  bool weights_due(const Scene& scene) { return has_frame_memory() && cast_.weights_due(scene, bindings()); }
  Result<void> add_weights(const Scene& scene) { return cast_.add_weights(scene, bindings()); }
  void drop_held_weights() { cast_.drop_held_weights(); }

  /// Whether the next piece of pass 0 or 1 runs on the processor, and can run now.
  bool works_here() const {
    if (frames_.is_prepared_here() && !frames_.done()) return true;
    return cast_.casts_here() && !cast_.submitted() && cast_.recorder().outstanding() == 0;
  }
  bool cast_submitted() const { return frames_.done() && cast_.submitted(); }
  bool cast_nearly_submitted() const { return frames_.done() && cast_.nearly_submitted(); }

  using Earlier = LightPass::Earlier;
  /// Submits the first piece of passes 2 and 3; where one GPU runs all passes, all pieces. Precondition: no
  /// cast is under way, maps_are_written(), and nothing of passes 2 and 3 is outstanding. `before`: the view
  /// of this slot's last picture, absent where it found the surface elsewhere or there is none; where frames
  /// were replaced, their surface is blended with it (Scene::Filter::seam_frames).
  Result<void> light(const Scene& scene, const Earlier& earlier, const Earlier& before);
  /// As LightPass::blends().
  bool blends() const { return light_.blends(); }

  /// Submits the next piece of light(). Before it, where `changed` is not null, takes that scene over as
  /// LightPass::change(). Precondition: !light_submitted(), light_outstanding() is 0.
  Result<void> light_next_piece(const Scene* changed);
  /// Whether light() has submitted all pieces, and whether it has submitted more than the filter.
  bool light_submitted() const { return light_.steps().submitted(); }
  bool light_begun() const { return light_.steps().begun(Stage::kLight); }
  /// As LightPass::lights_here().
  bool lights_here() const { return light_.lights_here(); }

  /// Where LightPass reads the maps in place always true: it waits.
  bool maps_are_written() const { return reads_in_place_ || cast_.maps_are_written(); }

  /// As LightPass::lights_a_part().
  bool lights_a_part() const { return light_.lights_a_part(); }

  /// Number of submissions that are not finished: of both passes, or of passes 2 and 3.
  std::uint64_t outstanding() const { return cast_.recorder().outstanding() + light_outstanding(); }
  std::uint64_t light_outstanding() const { return light_.recorder().outstanding(); }
  Result<void> retry_held();
  void drop_held();

  // Of the main view. Precondition: nothing is outstanding.
  void read_picture(const PictureStamp& stamp, Picture& to) const { light_.read_picture(stamp, to); }
  std::span<const float> depth_mm() const { return light_.depth_mm(); }
  /// Those of the cast are 0 where the picture is not the first of its cast.
  std::array<StageSpan, kStages> stage_spans() const;
  std::array<double, kStages> stage_ms() const;
  Result<DepthMaps> read_depth();
  Result<std::uint64_t> read_sample_count() { return cast_.read_sample_count(); }

  /// The temporally filtered depth map, on the device of pass 1, for LightPass::follow() of private views.
  /// Precondition: nothing is outstanding.
  const GpuBuffer& steady_for_private_views() const;

  /// The main view's pass 1, for private views; work goes through the functions above.
  const CastPass& cast() const { return cast_; }

  const SubmissionTimeline& cast_timeline() const { return cast_.recorder().timeline(); }
  const SubmissionTimeline& light_timeline() const { return light_.recorder().timeline(); }

  /// The parts of the volume that views read. Precondition: loaded().
  VolumeBindings bindings() {
    return {.frames = frames_,
            .angles = angles_,
            .table = table_,
            .geometry = geometry_,
            .extent = extent_,
            .levels = levels_,
            .near_tissue = near_tissue_,
            .frames_gone = frames_gone_,
            .written = cast_timeline().newest()};
  }

  /// Whether the frames that rays sample are those of the main view's cast.
  bool frames_ready() const {
    return loaded() && has_frame_memory() && frames_.done() && !changed() && !frames_gone_;
  }
  /// Changes whenever the frames change.
  std::uint64_t frames_version() const { return frames_version_; }

  /// Changes with the memory that bindings() names.
  std::uint64_t bindings_version() const { return bindings_version_; }

  /// Whether the cast under way leaves out the requested speckle filter; see FrameStore::begin.
  bool filter_left_out() const { return frames_.filter_left_out(); }

  /// Those of load().
  const EchoLevels& levels() const { return levels_; }
  /// What a picture of the scene shows of the near tissue.
  NearTissueState near_tissue_state(const Scene& scene) const { return near_tissue_.state(scene.near); }
  /// PictureStamp::near_end_mm.
  double near_end_mm(const Scene& scene) const {
    return fanlight::near_end_mm(scene, geometry_, extent_, near_tissue_);
  }
  /// PictureStamp::sample_distances.
  Point sample_distances(const Scene& scene) const {
    return geometry_.sample_distances(scene.camera.target, extent_.frame_step_rad());
  }
  /// The scene with what it leaves to this volume.
  Scene effective(const Scene& scene) const { return effective(scene, levels_); }

  bool loaded() const { return volume_.frames > 0; }
  const VolumeStamp& volume() const { return volume_; }

 private:
  Scene effective(const Scene& scene, const EchoLevels& levels) const {
    return effective_scene(scene, geometry_, config_.size, levels);
  }
  VolumeInFlight(const PassDevice& device, const Config& config)
      : device_(device),
        config_(config),
        table_(config.first_angle_rad, config.last_angle_rad, config.frame_capacity) {
    angles_rad_.reserve(config.frame_capacity);
  }
  /// False after a load() for which there was no memory.
  bool has_frame_memory() const { return frames_.frame_capacity() > 0; }
  Result<void> create_passes(const PassDevice* light_device);
  std::array<double, kStages> sums_of_pieces_ms() const;
  Result<void> create_frames(const FanGeometry& geometry, std::uint32_t frames);
  Result<void> replace_frames(const Volume& volume);
  Result<void> begin_frames(const Scene& scene, const EchoLevels& levels);
  void bind_cast();
  void mark_changed(std::uint32_t frame_index);
  void update_angles();
  void add_missing_frames(const Volume& volume);

  PassDevice device_;
  Config config_;
  AngleTable table_;
  std::vector<double> angles_rad_;  // of the frames, ascending
  NewFrames new_frames_;            // since load()
  // Range of frames that were replaced since the cast, and whether a change needs a whole cast.
  std::optional<CastPass::FrameRange> changed_;
  bool changed_beyond_ = false;
  FanGeometry geometry_;  // of the volume, as the next two
  VolumeStamp volume_;
  VolumeExtent extent_;
  EchoLevels levels_;
  NearTissueSearch near_tissue_;
  bool frames_gone_ = false;  // frames of the next volume were staged since the cast
  std::uint64_t frames_version_ = 0;
  std::uint64_t bindings_version_ = 0;
  FrameStore frames_;
  AngleBuffer angles_;
  // After those whose memory their descriptors name.
  CastPass cast_;
  LightPass light_;
  bool reads_in_place_ = true;  // light_ reads the maps of cast_ where they are
  GpuBuffer steady_copy_;       // of the map of light_, on the device of cast_; not where one GPU does all
};

}  // namespace fanlight
