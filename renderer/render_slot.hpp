#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "proto/frame_feed.hpp"
#include "proto/picture.hpp"
#include "proto/volume.hpp"
#include "renderer/angle_buffer.hpp"
#include "renderer/angle_table.hpp"
#include "renderer/frame_store.hpp"
#include "renderer/passes.hpp"
#include "renderer/volume_view.hpp"

namespace fanlight {

/// Everything that one volume in flight needs on the GPU: its frames, its angle table, and the main view of
/// it. Two may be in flight; they share nothing but that the filter of each reads the last depth map of the
/// other, on the one queue that runs both. Render thread only.
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
  void follow(const Gpu& gpu, const RenderSlot& other) { view_.follow(gpu, other.view_); }

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
  bool can_recast() const { return changed_.has_value() && !changed_beyond_ && view_.notes_reach(); }

  /// Submits passes 0 and 1 for the frames that were replaced, of pass 1 the tiles whose rays they can have
  /// changed; light() comes next. Precondition: can_recast(), nothing is outstanding, the scene is that of
  /// the cast.
  Result<void> recast(const Gpu& gpu, Passes& passes, const Scene& scene);

  /// Sets passes 0 and 1 up; nothing is submitted yet. Also gives up a cast under way. Precondition: nothing
  /// is outstanding. Error: a pipeline that cannot be built.
  Result<void> begin_cast(const Gpu& gpu, Passes& passes, const Scene& scene);

  /// Of the last volume or frames, ascending.
  std::span<const double> angles_rad() const { return angles_rad_; }

  /// As VolumeView's.
  Result<void> cast_next_band(const Gpu& gpu, const Passes& passes) {
    return view_.cast_next_band(gpu, passes, seen());
  }
  bool cast_submitted() const { return frames_.done() && view_.cast_submitted(); }
  using Past = VolumeView::Past;
  Result<void> light(const Gpu& gpu, Passes& passes, const Scene& scene, Past past) {
    return view_.light(gpu, passes, scene, seen(), past);
  }
  std::uint64_t outstanding(const Gpu& gpu) const { return view_.outstanding(gpu); }

  /// The main view; what is done with it is done through the slot.
  VolumeView& view() { return view_; }
  const VolumeView& view() const { return view_; }

  /// What other views of the volume read. Precondition: loaded().
  SeenVolume seen() {
    return {.frames = frames_,
            .angles = angles_,
            .table = table_,
            .geometry = geometry_,
            .extent = extent_,
            .frames_gone = frames_gone_,
            .timeline = view_.timeline(),
            .submissions = view_.submissions()};
  }

  /// Whether the frames are those of the main view's cast, where rays sample them; and a number that is
  /// another one when they have changed.
  bool frames_ready() const { return loaded() && frames_.done() && !changed(); }
  std::uint64_t frames_turn() const { return frames_turn_; }

  /// Whether the cast under way leaves out the speckle filter asked for; see FrameStore::begin.
  bool filter_left_out() const { return frames_.filter_left_out(); }

  bool loaded() const { return volume_.frames > 0; }
  const VolumeStamp& volume() const { return volume_; }

 private:
  explicit RenderSlot(const Config& config)
      : config_(config), table_(config.first_angle_rad, config.last_angle_rad, config.frame_capacity) {
    angles_rad_.reserve(config.frame_capacity);
  }
  Result<void> create_frames(const Gpu& gpu, const FanGeometry& geometry, std::uint32_t frames);
  Result<void> replace_frames(const Gpu& gpu, const Volume& volume);
  Result<void> begin_frames(const Gpu& gpu, Passes& passes, const Scene::Speckle& options);
  void change(std::uint32_t place);
  void place_angles();

  Config config_;
  AngleTable table_;
  std::vector<double> angles_rad_;  // of the frames, ascending
  // By place, frames that are not those of the cast; and whether more changed than frames within the fan.
  std::optional<VolumeView::Places> changed_;
  bool changed_beyond_ = false;
  FanGeometry geometry_;  // of the volume, as are the next two
  VolumeStamp volume_;
  VolumeExtent extent_;
  bool frames_gone_ = false;  // others were staged since the cast
  std::uint64_t frames_turn_ = 0;
  FrameStore frames_;
  AngleBuffer angles_;
  VolumeView view_;  // last: it names the others' memory
};

}  // namespace fanlight
