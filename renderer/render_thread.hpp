// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "proto/exchange/frame_queue.hpp"
#include "proto/exchange/render_link.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "renderer/cine.hpp"
#include "renderer/health_reporter.hpp"
#include "renderer/replaceable_renderer.hpp"
#include "renderer/schedule/private_share.hpp"
#include "renderer/schedule/rate_governor.hpp"
#include "renderer/schedule/size_governor.hpp"

namespace fanlight {

/// The thread that owns the renderer. It takes volumes from the ring, and scenes and orders from the link,
/// and sends pictures and answers back. It keeps the picture rate where the scene has a plan for it. While no
/// client is present, new volumes are taken and counted, but not rendered. It sleeps on its bell while there
/// is no work. Starts in the constructor.
///
/// Where the GPU is lost, hangs or has no memory left, the thread continues with a new renderer
/// (ReplaceableRenderer): with the newest scene, the private views, and the last volume until the next one
/// comes. Where that gives up, the thread sends an Error, and ends.
class RenderThread {
 public:
  using Remake = ReplaceableRenderer::Remake;

  /// All must outlive the thread. The ring and the feed ring the bell of the link's reader.
  struct Dependencies {
    VolumeRing& ring;
    RenderLink& link;
    RenderCounters& counters;
    FrameQueue* feed = nullptr;  ///< frames ahead of their volumes; may be null
    Remake remake{};             ///< empty: a lost GPU ends the thread
  };

  RenderThread(DeviceRenderer renderer, const Dependencies& dependencies);
  /// Ends the thread and waits for it: for as long as the watchdog lets the GPU work, and for ever where the
  /// driver does not return from a call. end() before it has a limit.
  ~RenderThread();

  /// Asks the thread to end and waits, at most timeout_ns. True where it has ended and nothing is left of its
  /// devices. Otherwise the process must end by std::_Exit, without the destructor.
  bool end(std::int64_t timeout_ns);

 private:
  void run(const std::stop_token& stop);
  Result<void> step();
  /// step(); a lack of memory is an error as the loss of the GPU.
  Result<void> step_within_memory();
  bool recover_within_memory(const Error& cause, const std::stop_token& stop);
  Result<void> take_volume();
  Result<void> load(Renderer::Loading loading);
  Result<void> load_kept(const Volume& volume);
  void follow_geometry(const Volume& volume);
  bool volume_waits() const;
  bool is_watched() const { return to_.link.audience.present(); }
  void look_for_audience();
  void note_volume();
  void load_again();
  void take_orders();
  void obey(const CineOrder& order);
  void obey(VolumeOrder& order);
  void take_frames();
  Result<void> take_private_views();
  const Volume* volume_on_show() const;
  void answer_volume_order();
  bool has_unsent() const;
  void report();
  void report_cine();
  void measure_busy();
  void take_scene();
  bool quality_changed(std::int64_t now_ns) const;
  std::optional<PictureSize> size_in_force(std::int64_t now_ns) const;
  void show_degraded();
  void rest();

  Dependencies to_;
  HealthReporter health_;
  ReplaceableRenderer renderer_;
  RateGovernor governor_;
  SizeGovernor sizes_;
  PrivateShare private_share_;
  NumberedScene requested_;       // the renderer shows it as degraded() by the plan
  std::int64_t measured_ns_ = 0;  // time of the last measure_busy()
  std::int64_t window_ns_ = 0;    // start of the window of the busy share
  std::int64_t busy_ns_ = 0;      // of the main view in the window
  double finest_mm_ = 0;          // step of the newest volume's rays where the scene sets none

  // For the time after a loss. The volume that was loaded last keeps its slot of the ring.
  VolumeRing::Lease volume_;
  Cine cine_;
  CineStatus reported_cine_;
  std::optional<VolumeOrder> volume_order_;  // to be answered
  std::optional<PrivateViewEnds> ends_due_;  // to be reported
  PrivateViews views_;
  std::size_t short_in_a_row_ = 0;   // volumes for which there was no memory
  bool remade_for_memory_ = false;   // and no volume was loaded since
  bool volume_due_ = false;          // the renderer is new, and has no volume yet
  bool views_due_ = false;           // nor its private views
  bool was_busy_ = false;            // at the last measure_busy()
  std::uint64_t arrivals_seen_ = 0;  // Audience::arrivals() at the last look_for_audience()

  std::atomic<std::int64_t> settle_ns_;  // how long the end waits for the GPU
  Doorbell ended_;                       // rings once the thread has nothing more to do
  std::jthread thread_;                  // last: it uses the others
};

}  // namespace fanlight
