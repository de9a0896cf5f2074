// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <thread>

#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/frame_queue.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "proto/model/picture.hpp"
#include "renderer/renderer.hpp"
#include "renderer/schedule/rate_governor.hpp"

namespace fanlight {

/// The thread that owns the renderer. It takes volumes from the ring and scenes from a mailbox, and publishes
/// pictures in another mailbox. It keeps the picture rate where the scene has a plan for it. It sleeps on its
/// bell while there is no work. Starts in the constructor, ends in the destructor.
class RenderThread {
 public:
  /// All must outlive the thread. `bell` is the bell that the ring and the scene mailbox ring for their
  /// reader.
  struct Dependencies {
    VolumeRing& ring;
    Mailbox<NumberedScene>& scenes;
    Mailbox<Picture>& pictures;
    RenderCounters& counters;
    Doorbell& bell;
    /// Receives one error if the renderer cannot continue (the GPU was lost); the thread has then ended.
    Mailbox<Error>& failures;
    /// Frames ahead of their volumes; may be null.
    FrameQueue* feed = nullptr;
    /// Requested private views; may be null.
    Mailbox<PrivateViews>* private_views = nullptr;
  };

  RenderThread(std::unique_ptr<Renderer> renderer, const Dependencies& dependencies);
  ~RenderThread();

 private:
  void run(const std::stop_token& stop);
  Result<void> step();
  Result<void> take_volume();
  void take_frames();
  Result<void> take_private_views();
  void measure_busy();
  void take_scene();
  void show_degraded();
  void rest();

  std::unique_ptr<Renderer> renderer_;
  Dependencies to_;
  RateGovernor governor_;
  NumberedScene requested_;       // the renderer shows it as degraded() by the plan
  std::int64_t measured_ns_ = 0;  // time of the last measure_busy()
  std::int64_t window_ns_ = 0;    // start of the window of the busy share
  std::int64_t busy_ns_ = 0;      // of the main view in the window
  bool was_busy_ = false;
  double finest_mm_ = 0;  // step of the newest volume's rays where the scene sets none
  std::jthread thread_;   // last: it uses the others
};

}  // namespace fanlight
