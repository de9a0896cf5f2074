#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "proto/picture.hpp"
#include "proto/scene.hpp"
#include "renderer/renderer.hpp"
#include "server/bench_volumes.hpp"

namespace fanlight {

/// A renderer, the volumes that it is shown, and a clock. One thread.
class BenchRig {
 public:
  /// `picture`: its side, pixels. The volumes must outlive the rig.
  BenchRig(const Gpu& gpu, BenchVolumes& volumes, const Scene& scene, int picture)
      : gpu_(gpu), volumes_(volumes), scene_{.revision = 1, .scene = scene}, picture_(picture) {}

  Result<void> start(Skipping skipping);

  // Each takes the time from the call to the finished picture, ms.

  /// All of the next volume comes at once.
  Result<double> whole_volume();

  /// The last frame of the next volume comes; all others were there before. Precondition: a volume came
  /// before it, as frames are wanted ahead only then.
  Result<double> new_volume();

  /// Each frame of the next sweep as it comes.
  Result<std::vector<double>> rolling_sweep();

  /// The scene changes; `sign` is 1 and -1 in turn.
  Result<double> change(void (*how)(Scene&, double sign));

  const Picture& picture() const { return shown_; }
  Renderer& renderer() { return *renderer_; }

 private:
  Result<void> take(std::uint32_t index);
  Result<double> picture_since(std::int64_t from_ns);

  const Gpu& gpu_;
  BenchVolumes& volumes_;
  NumberedScene scene_;
  int picture_;
  double sign_ = 1;
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_;
  Picture shown_;
};

}  // namespace fanlight
