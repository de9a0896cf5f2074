#pragma once

#include <memory>
#include <thread>

#include "proto/doorbell.hpp"
#include "proto/frame_feed.hpp"
#include "proto/mailbox.hpp"
#include "proto/picture.hpp"
#include "proto/volume_ring.hpp"
#include "renderer/deadline.hpp"
#include "renderer/renderer.hpp"

namespace fanlight {

/// The thread that owns the renderer: takes volumes from the ring and scenes from a mailbox, leaves pictures
/// in another. Holds the rate of pictures where the scene has a plan for it. Sleeps on its bell while there
/// is nothing to do. Starts when made, ends when destroyed.
class RenderThread {
 public:
  /// All must outlive the thread. `bell` is the one that the ring and the scene mailbox ring for a reader.
  struct Dependencies {
    VolumeRing& ring;
    Mailbox<NumberedScene>& scenes;
    Mailbox<Picture>& pictures;
    RenderCounters& counters;
    Doorbell& bell;
    /// Left here once if the renderer can't go on (the GPU was lost); the thread has then ended.
    Mailbox<Error>& failures;
    /// Frames ahead of their volumes; may be null.
    FrameFeed* feed = nullptr;
    /// Views beside the main one; may be null.
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
  void note_busy();
  void take_scene();
  void show_planned();
  void rest();

  std::unique_ptr<Renderer> renderer_;
  Dependencies to_;
  Deadline deadline_;
  NumberedScene asked_;         // the renderer has what its plan makes of it
  std::int64_t noted_ns_ = 0;   // of the last step
  std::int64_t window_ns_ = 0;  // since when the next is counted
  std::int64_t busy_ns_ = 0;    // of the main view
  bool was_busy_ = false;
  double finest_mm_ = 0;  // step of the newest volume's rays where the scene names none
  std::jthread thread_;   // last: it uses the others
};

}  // namespace fanlight
