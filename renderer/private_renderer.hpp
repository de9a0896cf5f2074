// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "proto/base/thread_owner.hpp"
#include "proto/exchange/private_view.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "renderer/schedule/private_schedule.hpp"
#include "renderer/volume_in_flight.hpp"

namespace fanlight {

/// Draws private views of the shown volume, one piece of work at a time: a band of pass 1 that is a fraction
/// of the main view's, or some dispatches of passes 2 and 3. If advance() is called only while the main view
/// has no work, the main view waits for one such piece at most. A picture whose frames are replaced before it
/// has read them is given up and begins again. Its first piece of passes 2 and 3 copies the main view's depth
/// map.
///
/// Owns a LightPass per private view, and a CastPass for one with a camera of its own, allocated when first
/// requested and kept. All are on the device of the main view's pass 1.
/// renderer/schedule/private_schedule.hpp decides the order of the work. Render thread only.
class PrivateRenderer {
 public:
  /// `cast`: the size of the pictures is that of their passes.
  PrivateRenderer(const PassDevice& device, RenderCounters& counters, const CastPass::Config& cast)
      : device_(device), counters_(counters), cast_config_(cast) {}

  /// Sets the requested views. Allocates for each new view. A view that the GPU has no memory for, or fails
  /// to draw, is counted and ends; the others stay. Error: kLost.
  Result<void> want(const PrivateViews& views);

  /// The views that have ended so far; nullptr where none has since the last call.
  const PrivateViewEnds* ended_views() { return std::exchange(ends_changed_, false) ? &ends_ : nullptr; }

  /// What a new renderer continues: the numbers of pictures, and the views that have ended.
  struct Progress {
    struct View {
      std::uint64_t view_id = 0;
      std::uint64_t pictures = 0;
    };
    std::array<View, kMostPrivateViews> views{};
    PrivateViewEnds ends{};
  };
  Progress progress() const;
  void resume(const Progress& progress);

  /// What the main view shows.
  struct Shown {
    VolumeInFlight& slot;
    const VolumeInFlight& previous;  ///< the slot of the volume before
    const Scene& cast_scene;         ///< of the depth map in the slot
    std::uint64_t cast_number = 0;   ///< of the depth map, from 1
    LightPass::Earlier earlier{};
    PictureSize usual_size{};  ///< of scenes that have none
  };

  /// Submits one piece of the work that is due; whether there was some. Precondition: nothing of the main
  /// view is outstanding, and this is not busy(). Error: kLost; other errors end the view alone.
  Result<bool> advance(const Shown& shown);

  // As SubmissionTimeline::retry() and drop_held(), for all views.
  Result<void> retry_held();
  void drop_held();

  /// The timelines of the passes of a view by its index; nullptr where it has no such pass.
  std::array<const SubmissionTimeline*, 2> timelines(std::size_t index) const;

  /// Leaves the memory of all views to the end of the process.
  void leave_memory();

  /// Copies the finished pictures to their mailboxes; whether there was one.
  bool collect();

  /// The timeline of the work that is outstanding on the GPU, or nullptr.
  const SubmissionTimeline* outstanding_timeline() const;

  /// Whether work is outstanding on the GPU, or a picture waits for collect().
  bool busy() const;

  /// Whether a view has work to do, or has some under way.
  bool due(const Shown& shown) const;

  /// Whether outstanding work reads the slot.
  bool reads(const VolumeInFlight& slot) const;

 private:
  struct ViewState {
    PrivateView wanted;
    std::optional<LightPass> light;
    std::optional<CastPass> cast;
    WorkPhase phase = WorkPhase::kIdle;
    // Of the work under way, or done last.
    VolumeInFlight* slot = nullptr;
    Scene scene;
    std::uint64_t revision = 0;
    std::uint64_t frames_version = 0;  // as of VolumeInFlight, as the next
    std::uint64_t bindings_version = 0;
    std::uint64_t cast_number = 0;  // Shown::cast_number; 0: a cast of its own
    PictureStamp stamp;
    std::uint64_t pictures = 0;
    bool drawn = false;  // there was a picture since the view was opened

    bool casts() const { return cast_number == 0; }
    bool awaits_collection() const { return phase == WorkPhase::kLighting && light->steps().submitted(); }
    std::uint64_t outstanding() const {
      return (light ? light->recorder().outstanding() : 0) + (cast ? cast->recorder().outstanding() : 0);
    }
  };
  LightPass::Config light_config(PictureSize largest) const;
  Result<void> create_passes(ViewState& state) const;
  Result<void> fit_light(ViewState& state, PictureSize size) const;
  static void drop_passes(ViewState& state);
  static bool inputs_lost(const ViewState& state);
  std::array<PrivateStatus, kMostPrivateViews> status(const Shown& shown) const;
  std::optional<PrivateAction> next_action(const Shown& shown) const;
  Result<void> execute(PrivateStep step, ViewState& state, const Shown& shown);
  void end(ViewState& state, const Error& error);
  static Scene requested_scene(const ViewState& state, const Shown& shown);
  void take_request(ViewState& state, const Shown& shown);
  Result<void> begin_cast(ViewState& state, const Shown& shown);
  static Result<void> add_weights(ViewState& state);
  static LightPass::Earlier earlier_of(const ViewState& state, const Shown& shown);
  Result<void> light(ViewState& state, const Shown& shown);
  static std::array<double, kStages> stage_ms(const ViewState& state);

  PassDevice device_;
  RenderCounters& counters_;
  CastPass::Config cast_config_;
  std::array<ViewState, kMostPrivateViews> states_;
  std::size_t next_ = 0;  // view whose turn it is
  PrivateViewEnds ends_;
  bool ends_changed_ = false;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
