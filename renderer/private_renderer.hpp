#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "proto/counter.hpp"
#include "proto/private_view.hpp"
#include "renderer/render_slot.hpp"

namespace fanlight {

/// Draws private views of the volume on show, one piece of work at a time: a band of pass 1 that is a
/// fraction of the main view's, or all of passes 2 and 3. Whoever calls advance() only where the main view
/// has nothing to do makes it wait for one such piece at most. A cast whose frames are taken away under it is
/// given up and begun anew. Render thread only.
class PrivateRenderer {
 public:
  PrivateRenderer(const Gpu& gpu, Passes& passes, RenderCounters& counters,
                  const VolumeView::Config& view_config)
      : gpu_(gpu), passes_(passes), counters_(counters), view_config_(view_config) {}

  /// What is wanted from now on; allocates with a view that is new. One that the GPU has no memory for is
  /// counted and not drawn. Error: the GPU is broken.
  Result<void> want(const PrivateViews& views);

  /// What the main view shows.
  struct Shown {
    RenderSlot& slot;
    const RenderSlot& last;   ///< of the volume before
    const Scene& cast_scene;  ///< of the depth map in the slot
    std::uint64_t cast = 0;   ///< counts the depth maps
    VolumeView::Past past = VolumeView::Past::kNone;
  };

  /// Submits one piece of what is due, where there is something. Precondition: nothing of the main view is
  /// under way, nor of this.
  Result<void> advance(const Shown& shown);

  /// Leaves the pictures that are done in their mailboxes; whether there was one.
  bool collect();

  /// The view that the GPU works on, or nullptr.
  const VolumeView* under_way() const;

  /// Whether that reads what is in the slot.
  bool reads(const RenderSlot& slot) const;

 private:
  enum class Phase : std::uint8_t { kIdle, kCasting, kLighting };
  struct Place {
    PrivateView wanted;
    std::optional<VolumeView> view;
    Phase phase = Phase::kIdle;
    // Of the work under way, or done last.
    RenderSlot* slot = nullptr;
    Scene scene;
    std::uint64_t revision = 0;
    std::uint64_t frames = 0;  // RenderSlot::frames_turn()
    std::uint64_t cast = 0;    // Shown::cast; 0: the cast is its own
    PictureStamp stamp;
    std::uint64_t pictures = 0;
    bool drawn = false;  // there was a picture since the view was opened
  };
  bool due(const Place& place, const Shown& shown) const;
  Result<void> begin(Place& place, const Shown& shown);
  Result<void> go_on(Place& place, const Shown& shown);
  Result<void> light(Place& place, VolumeView::Past past);

  const Gpu& gpu_;
  Passes& passes_;
  RenderCounters& counters_;
  VolumeView::Config view_config_;
  std::array<Place, kMostPrivateViews> places_;
  std::size_t next_ = 0;  // whose turn it is
};

}  // namespace fanlight
