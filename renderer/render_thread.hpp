// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <thread>

#include "proto/exchange/audience.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/pulse.hpp"
#include "proto/exchange/render_health.hpp"
#include "proto/exchange/survey.hpp"
#include "proto/exchange/volume_order.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "proto/model/picture.hpp"
#include "renderer/cine.hpp"
#include "renderer/device_disposal.hpp"
#include "renderer/health_reporter.hpp"
#include "renderer/renderer.hpp"
#include "renderer/schedule/loss_record.hpp"
#include "renderer/schedule/private_share.hpp"
#include "renderer/schedule/rate_governor.hpp"

namespace fanlight {

/// The thread that owns the renderer. It takes volumes from the ring and scenes from a mailbox, and publishes
/// pictures in another mailbox. It keeps the picture rate where the scene has a plan for it. It sleeps on its
/// bell while there is no work. Starts in the constructor.
///
/// Where the GPU is lost, hangs or has no memory left, the thread makes the device and the renderer anew and
/// goes on: with the newest scene, the private views, and the last volume until the next one comes. Numbers
/// of pictures and counters continue. It gives up where LossRecord says so.
class RenderThread {
 public:
  /// Opens a device and creates a renderer of this scene. Called on the render thread; may block for seconds.
  using Remake = std::function<Result<DeviceRenderer>(const NumberedScene& scene)>;

  /// All must outlive the thread. `bell` is the bell that the ring and the scene mailbox ring for their
  /// reader.
  struct Dependencies {
    VolumeRing& ring;
    Mailbox<NumberedScene>& scenes;
    Mailbox<Picture>& pictures;
    RenderCounters& counters;
    Doorbell& bell;
    /// Receives one error if the renderer cannot continue; the thread has then ended.
    Mailbox<Error>& failures;
    /// Frames ahead of their volumes; may be null.
    FrameQueue* feed = nullptr;
    /// Requested private views; may be null.
    Mailbox<PrivateViews>* private_views = nullptr;
    /// Receives the private views that ended because of an error; may be null.
    Mailbox<PrivateViewEnds>* private_view_ends = nullptr;
    /// Orders to look for the surface of the last volume, and what was found; both null, or neither.
    Mailbox<SurveyOrder>* survey_orders = nullptr;
    Mailbox<SurveyResult>* survey_results = nullptr;
    /// Orders for a copy of the volume on show, and the answers; both null, or neither.
    Mailbox<VolumeOrder>* volume_orders = nullptr;
    Mailbox<VolumeAnswer>* volume_answers = nullptr;
    /// Orders to freeze and to show the last volumes; may be null.
    CineLink* cine = nullptr;
    /// While nobody is present, new volumes are taken and counted, but not rendered; null: they always are.
    const Audience* audience = nullptr;
    /// Beats while the thread's loop comes round; null: nobody watches.
    Pulse* pulse = nullptr;
    /// Receives the health whenever it changes; may be null. Its slots are roomy_health().
    Mailbox<RenderHealth>* health = nullptr;
    /// Empty: a lost GPU ends the thread.
    Remake remake{};
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
  bool is_watched() const { return to_.audience == nullptr || to_.audience->present(); }
  void look_for_audience();
  void take_cine_orders();
  void take_frames();
  Result<void> take_private_views();
  const Volume* volume_on_show() const;
  void take_survey_order();
  void take_volume_order();
  void report();
  void measure_busy();
  void take_scene();
  void show_degraded();
  void rest();

  // In render_thread_recovery.cpp.
  bool recover(const Error& cause, const std::stop_token& stop);
  bool remake(const NumberedScene& scene, const std::stop_token& stop);
  void dispose(const Error& cause);
  void fail(const Error& error);
  void pause(std::int64_t until_ns, const std::stop_token& stop) const;
  void retire();

  Renderer& renderer() { return *device_.renderer; }

  DeviceRenderer device_;
  Dependencies to_;
  RateGovernor governor_;
  PrivateShare private_share_;
  NumberedScene requested_;       // the renderer shows it as degraded() by the plan
  std::int64_t measured_ns_ = 0;  // time of the last measure_busy()
  std::int64_t window_ns_ = 0;    // start of the window of the busy share
  std::int64_t busy_ns_ = 0;      // of the main view in the window
  double finest_mm_ = 0;          // step of the newest volume's rays where the scene sets none

  // For the time after a loss. The volume that was loaded last keeps its slot of the ring.
  VolumeRing::Lease volume_;
  Cine cine_;
  PrivateViews views_;
  LossRecord losses_;
  std::size_t short_in_a_row_ = 0;   // volumes for which there was no memory
  bool remade_for_memory_ = false;   // and no volume was loaded since
  bool volume_due_ = false;          // the renderer is new, and has no volume yet
  bool views_due_ = false;           // nor its private views
  bool was_busy_ = false;            // at the last measure_busy()
  std::uint64_t arrivals_seen_ = 0;  // Audience::arrivals() at the last look_for_audience()
  DeviceDisposal disposal_;
  HealthReporter health_;

  std::atomic<std::int64_t> settle_ns_;  // how long the end waits for the GPU
  Doorbell ended_;                       // rings once the thread has nothing more to do
  std::jthread thread_;                  // last: it uses the others
};

}  // namespace fanlight
