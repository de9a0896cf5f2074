// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/base/result.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/model/picture.hpp"
#include "renderer/renderer.hpp"
#include "server/bench/live_feed.hpp"
#include "server/bench/stage_overlap.hpp"
#include "server/bench/volumes.hpp"
#include "server/codec/jpeg_coder.hpp"

namespace fanlight {

inline constexpr int kBenchJpegQuality = 85;  ///< the default of `fanlight serve`

/// Renders blocks of volumes with one renderer, encodes their pictures as JPEG, and records when the stages
/// ran. One thread.
class BlockRunner {
 public:
  /// Both must outlive the runner.
  BlockRunner(BenchVolumes& volumes, Renderer& renderer) : volumes_(volumes), renderer_(renderer) {}

  /// Loads, renders and encodes each volume before it loads the next one.
  Result<BlockTrace> serial(int volumes);

  /// Loads a volume whenever the renderer wants one. Another thread encodes the newest picture.
  Result<BlockTrace> pipelined(int volumes);

  /// As a live source whose sweeps take `sweep_ns`: frames are taken as they come, and a volume is loaded
  /// when it is complete and the renderer wants one. Renders `volumes` volumes; the trace has them alone.
  Result<BlockTrace> live(int volumes, std::int64_t sweep_ns, Arrival arrival = Arrival::kFrameByFrame);

 private:
  Result<void> load(BlockTrace& block, const Volume& volume);
  Result<void> render_and_collect();
  void take_frames(LiveFeed& feed);
  /// Whether a picture was finished: it is published, and its stages are in the trace.
  bool collect(BlockTrace& block, Mailbox<Picture>& pictures);
  void record_stages(BlockTrace& block, const Picture& picture) const;

  BenchVolumes& volumes_;
  Renderer& renderer_;
  JpegCoder encoder_{kBenchJpegQuality};
  Picture picture_;
};

}  // namespace fanlight
