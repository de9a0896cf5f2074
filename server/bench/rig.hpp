// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "proto/model/picture.hpp"
#include "proto/model/scene.hpp"
#include "renderer/renderer.hpp"
#include "server/bench/volumes.hpp"

namespace fanlight {

/// Measures one renderer with the volumes of a row. One thread.
class BenchRig {
 public:
  /// `picture`: side of the picture in pixels. The volumes must outlive the rig.
  BenchRig(const Gpu& gpu, BenchVolumes& volumes, const Scene& scene, int picture)
      : gpu_(gpu), volumes_(volumes), scene_{.revision = 1, .scene = scene}, picture_(picture) {}

  Result<void> start(Skipping skipping);

  // Each returns the time from the call to the finished picture in ms.

  /// Loads the whole next volume at once.
  Result<double> whole_volume();

  /// Only the last frame of the next volume is new; all others were taken before. Precondition: there was a
  /// volume before it, because the renderer accepts frames ahead only then.
  Result<double> new_volume();

  /// Takes the frames of the next sweep one by one, with a picture for each.
  Result<std::vector<double>> rolling_sweep();

  /// Changes the scene; `sign` alternates between 1 and -1.
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
