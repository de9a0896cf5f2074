#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>

#include "acquisition/acquisition_thread.hpp"
#include "renderer/render_thread.hpp"
#include "tests/hot_path/hot_threads.hpp"

namespace fanlight::test {

/// A source, the ring, the renderer and their two threads, joined as `fanlight serve` joins them, with the
/// test in the server's place: it reads pictures and leaves scenes. Test thread only.
class HotHouse {
 public:
  /// Starts the threads, cold. `blank` is what the mailbox of pictures is made with. Throws where there is no
  /// GPU.
  HotHouse(FrameSource& source, RingPolicy policy, const Picture& blank = blank_picture());
  ~HotHouse();

  /// A picture with all the memory that it will need.
  static Picture blank_picture();

  /// The scene that shows all of the source.
  const Scene& suggested() const { return suggested_; }

  /// Leaves a scene for the renderer and returns its revision.
  std::uint64_t show(const Scene& scene);

  /// The newest picture that was not read yet. Throws where none comes within half a minute, or a thread has
  /// given up.
  const Picture& next_picture();

  /// From now on both threads are hot, until the end.
  void make_hot();

  std::int64_t started_ns() const { return started_ns_; }
  const RenderCounters& counters() const { return render_counters_; }

 private:
  const Scene suggested_;
  std::uint64_t revision_ = 1;
  Doorbell acquisition_bell_;
  Doorbell render_bell_;
  Doorbell server_bell_;
  AcquisitionCounters acquisition_counters_;
  RenderCounters render_counters_;
  VolumeRing ring_;
  Mailbox<NumberedScene> scenes_{render_bell_};
  Mailbox<Picture> pictures_;
  Mailbox<Error> failures_{server_bell_};
  std::int64_t started_ns_ = 0;
  std::unique_ptr<RenderThread> render_;
  std::unique_ptr<AcquisitionThread> acquisition_;
  pid_t render_id_ = 0;
  pid_t acquisition_id_ = 0;
  // Cold again before they end: how a thread is taken down is not its hot path.
  std::optional<HotThread> hot_render_;
  std::optional<HotThread> hot_acquisition_;
};

}  // namespace fanlight::test
