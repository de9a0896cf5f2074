#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "proto/counter.hpp"
#include "proto/frame_feed.hpp"
#include "proto/picture.hpp"
#include "proto/volume.hpp"
#include "renderer/gpu.hpp"
#include "renderer/passes.hpp"
#include "renderer/private_renderer.hpp"
#include "renderer/render_slot.hpp"

namespace fanlight {

/// Turns volumes and scenes into pictures, with two volumes in flight: pass 1 of the next runs while passes 2
/// and 3 of the last do. A changed light re-runs passes 2 and 3 of the volume on show, a changed view also
/// pass 1; whichever, the newest scene wins. Each volume is shown by its own geometry, and the two in flight
/// may differ in it.
///
/// One thread, which calls show() and load() as they come, then advance(), collect() and wait() in turn.
class Renderer {
 public:
  struct Config {
    PictureSize size;
    FanGeometry geometry;        ///< of the first volumes; room is made for them at once
    double first_angle_rad = 0;  ///< between which most frames will lie
    double last_angle_rad = 0;
    std::uint32_t frame_capacity = 0;  ///< most frames of any volume
    /// Of most volumes: room is made for them at once, for more when they come. 0: as frame_capacity.
    std::uint32_t usual_frames = 0;
    Skipping skipping = Skipping::kOn;
    /// Absent: what suits the GPU.
    std::optional<Sampling> sampling;
  };
  /// Both must outlive the renderer.
  struct Dependencies {
    const Gpu& gpu;
    RenderCounters& counters;
  };

  /// Allocates all memory but pass 0's, which comes with the first volume that wants it, and builds the
  /// largest pipeline for `scene`. Errors: no memory on the GPU; a geometry, a volume or a picture beyond the
  /// GPU's limits.
  static Result<std::unique_ptr<Renderer>> create(const Config& config, const Dependencies& dependencies,
                                                  const NumberedScene& scene);
  ~Renderer();

  /// The scene that pictures from now on show.
  void show(const NumberedScene& scene) { scene_ = scene; }

  /// Whether load() would be taken: no pass 1 is under way and a slot is free.
  bool wants_volume() const;

  /// Takes a copy of the volume and casts it with the next advance(). A volume too large for the GPU's limits
  /// or memory is refused and counted, and what is shown stays. Allocates where its columns or rows are not
  /// those of the volume it replaces, or its frames are more than any before. Precondition: wants_volume(),
  /// at most frame_capacity frames.
  Result<void> load(const Volume& volume);

  /// Whether take_frame() would be taken: the slot of the volume to come is free.
  bool wants_frame() const;

  /// Takes a copy of a frame of the volume to come, for pass 0 to be done with it before the others are
  /// there. Its place is guessed by its angle from the last volume's; load() mends wrong guesses.
  /// Precondition: wants_frame().
  void take_frame(const FedFrame& frame);

  /// Submits whatever is due and can go now. Never waits for the GPU.
  Result<void> advance();

  /// True where a picture was done and has been copied to `picture`, whose buffer is reused.
  bool collect(Picture& picture);

  /// When each stage of the picture collected last ran. Precondition: its slot has not taken another volume
  /// since. For benchmarks.
  std::array<StageSpan, kStages> stage_spans() const {
    return flights_[shown_]->slot.view().stage_spans(gpu_);
  }

  /// Private views of what is shown, from now on; allocates with one that is new.
  Result<void> want(const PrivateViews& views);

  /// Submits a piece of a private view's work, where some is due and the main view has none under way. The
  /// main view's next work waits for that piece.
  Result<void> advance_private();

  /// Leaves private pictures that are done in their mailboxes; whether there was one.
  bool collect_private() { return private_.collect(); }

  /// Whether anything is under way on the GPU; of the main view alone.
  bool busy() const { return main_busy() || private_.under_way() != nullptr; }
  bool main_busy() const;

  /// Waits until the GPU has done something more, timeout_ns at most.
  Result<void> wait(std::int64_t timeout_ns);

  /// The depth maps of the picture collected last. Precondition: !busy(). For tests and one-shot rendering.
  Result<DepthMaps> read_depth();

  const Config& config() const { return config_; }
  const NumberedScene& scene() const { return scene_; }

 private:
  /// idle -> casting (pass 1's bands are being submitted) -> lighting (passes 2 and 3 were) -> idle.
  enum class Phase : std::uint8_t { kIdle, kCasting, kLighting };
  struct Flight {
    RenderSlot slot;
    Phase phase = Phase::kIdle;
    NumberedScene cast_scene;  // of the depth map in the slot
    NumberedScene lit_scene;   // of the picture in the slot
    std::uint64_t cast = 0;    // counts the depth maps
    PictureStamp stamp;
    bool awaits_picture = false;  // its volume has had none
    bool gave_up_cast = false;    // the cast under way replaces one for a view that nobody wants any more
    // The volume and the view of the depth map that the next volume's is drawn towards.
    std::uint64_t filtered_volume_id = 0;
    Scene filtered_view;
  };

  Renderer(const Config& config, const Dependencies& dependencies, const NumberedScene& scene,
           std::unique_ptr<Passes> passes, const VolumeView::Config& private_views)
      : config_(config),
        gpu_(dependencies.gpu),
        counters_(dependencies.counters),
        passes_(std::move(passes)),
        private_(gpu_, *passes_, counters_, private_views),
        scene_(scene) {}
  bool settled(const Flight& flight) const;
  Result<void> begin_cast(Flight& flight);
  std::uint32_t place_of(double angle_rad) const;
  Result<void> light(Flight& flight);
  Result<void> prepare_ahead();
  // Refresh::kFrame: one slot, whose frames are replaced as they come.
  bool rolls() const;
  std::size_t next() const;
  Result<void> complete(const Volume& volume);
  Result<void> recast(Flight& flight);
  RenderSlot::Past past_of(const Flight& flight) const;
  bool view_changed(const Flight& flight) const;
  bool light_changed(const Flight& flight) const;

  Config config_;
  const Gpu& gpu_;
  RenderCounters& counters_;
  std::unique_ptr<Passes> passes_;
  std::array<std::unique_ptr<Flight>, 2> flights_;
  PrivateRenderer private_;
  std::size_t newest_ = 0;  // the flight loaded last; the other one takes the next volume
  std::size_t shown_ = 0;   // the flight whose picture was collected last
  std::uint64_t shown_volume_id_ = 0;
  std::uint64_t newest_arrival_ = 0;  // of the frames of the last volume
  NumberedScene scene_;
  std::uint64_t pictures_ = 0;
};

}  // namespace fanlight
