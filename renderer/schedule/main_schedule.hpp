// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "proto/model/scene.hpp"
#include "renderer/schedule/work_phase.hpp"

namespace fanlight {

// The order of the main view's work, without a GPU: pure functions of a snapshot and of the newest scene.
// None of them allocates or blocks.

/// Snapshot of one of the two volume slots of the main view.
struct SlotStatus {
  WorkPhase phase = WorkPhase::kIdle;
  bool loaded = false;                        ///< holds a volume
  bool outstanding = false;                   ///< the GPU has not finished its submissions
  bool light_outstanding = false;             ///< of these, the ones of passes 2 and 3
  bool light_begun = true;                    ///< more of passes 2 and 3 was submitted than the filter
  bool light_submitted = true;                ///< all of passes 2 and 3 was submitted
  bool read_by_private_view = false;          ///< work of a private view that reads the slot is outstanding
  bool cast_submitted = false;                ///< all bands of pass 1 were submitted
  bool cast_nearly_submitted = false;         ///< the last quarter of pass 1, or its last band, comes next
  bool gave_up_cast = false;                  ///< the cast under way replaced one whose view was outdated
  bool refines = false;                       ///< the cast under way is a finer one of the picture on show
  bool map_lost = false;                      ///< a cast that was given up has overwritten the depth map
  bool frames_changed = false;                ///< frames were replaced since the cast
  bool can_recast = false;                    ///< casting the dirty tiles suffices for the replaced frames
  bool frames_staged = false;                 ///< frames of its next volume were staged since the cast
  const NumberedScene* cast_scene = nullptr;  ///< of the depth map in the slot; not null
  const NumberedScene* lit_scene = nullptr;   ///< of the picture in the slot; not null

  /// Nothing on the GPU uses the slot, so its memory may be written.
  bool settled() const { return !outstanding && !read_by_private_view; }
};

struct MainStatus {
  std::array<SlotStatus, 2> slots;
  std::size_t newest = 0;     ///< slot that was loaded last
  std::size_t shown = 0;      ///< slot whose picture was collected last
  bool volume_waits = false;  ///< in the ring: it is loaded when the cast ends
  /// The processor runs the passes: a step is done at its return, and the ones after it wait for it.
  bool runs_here = false;

  std::size_t other() const { return 1 - newest; }
};

/// Whether the depth map was cast for another view than the scene's.
bool view_changed(const NumberedScene& cast_scene, const NumberedScene& scene);

/// Whether two scenes differ in the size of their pictures, and else in nothing that casts rays.
bool differs_in_size_alone(const Scene& from, const Scene& to);

/// Whether the depth map can give a picture that the slot does not hold yet: of a new light, or of a new
/// revision.
bool light_changed(const SlotStatus& slot, const NumberedScene& scene);

/// Refresh::kFrame is in force: a single slot is used, and its frames are replaced one by one.
/// `loaded`, `cast_scene`: of the newest slot.
bool replaces_frames(bool loaded, const NumberedScene& cast_scene, const NumberedScene& scene);

/// The volume of a depth map; id 0: there is none.
struct MappedVolume {
  std::uint64_t id = 0;
  bool is_kept = false;  ///< it is one of the cine's
};

/// Whether a depth map may be averaged with that of another volume, or of the same one loaded again. The cine
/// shows volumes in any order, each alone; but the one that a display freezes keeps what was averaged while
/// it was live.
bool may_average(const MappedVolume& map, const MappedVolume& now);

/// Whether a volume can be loaded: no cast is under way that a picture waits for, nor, where the processor
/// runs the passes, the light of a picture; and the slot that will take the volume is idle and settled.
bool accepts_volume(const MainStatus& status, const NumberedScene& scene);

/// Whether the cast under way is given up for a new volume, between two of its bands.
bool gives_way(const SlotStatus& slot);

/// Whether a frame can be staged: the slot that will take it is idle and settled, and a volume was loaded
/// whose angles give the index of the frame.
bool accepts_frame(const MainStatus& status, const NumberedScene& scene);

/// Whether a frame in the queue stays there until the volume that waits in the ring is loaded, because it
/// belongs to a volume after that one. Frames that replace those of the last volume all stay.
/// `waiting_commit_number`: VolumeRing::waiting_commit_number().
bool stays_queued(std::uint64_t commit_number, std::optional<std::uint64_t> waiting_commit_number,
                  bool replaces_frames);

/// One step of the main view's work. kLightShown concerns the shown slot, kPrepareAhead and
/// kLightPieceOfOther the other slot than the newest, the remaining ones the newest slot.
enum class MainStep : std::uint8_t {
  kBeginCast,          ///< set up pass 1 for the newest scene; submits nothing
  kRestartCast,        ///< the same in the middle of a cast whose view is outdated
  kLightShown,         ///< submit passes 2 and 3, or first the weights of the depth filter
  kRecast,             ///< submit pass 1 for the dirty tiles
  kCastBand,           ///< submit the next band of passes 0 and 1
  kLightCast,          ///< the same for the finished cast
  kLightPiece,         ///< submit the next piece of them
  kLightPieceOfOther,  ///< the same for the other slot
  kPrepareAhead        ///< submit pass 0 for frames that were staged ahead of their volume, if there are any
};

/// Up to four steps, in order.
class MainSteps {
 public:
  void add(MainStep step) { steps_[count_++] = step; }
  std::span<const MainStep> steps() const { return std::span(steps_).first(count_); }

 private:
  std::array<MainStep, 4> steps_{};
  std::size_t count_ = 0;
};

/// The steps that are due and that the GPU can take now. They may be empty.
MainSteps decide(const MainStatus& status, const NumberedScene& scene);

}  // namespace fanlight
