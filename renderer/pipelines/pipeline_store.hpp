// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "renderer/pipelines/pipelines.hpp"

namespace fanlight {

/// Keeps the pipelines of a device for the next renderer on it, so that it does not build them again, which
/// takes a second or more on a processor. Keeps every variant that was asked for (detector window, mode, kind
/// of frames) until clear(). Must outlive its renderers; the devices must outlive it. One thread.
class PipelineStore {
 public:
  /// The pipelines of a device and a sampling. The first call for them builds them with the cache of
  /// `config`; later calls ignore that cache. Error: a pipeline that cannot be built.
  Result<std::shared_ptr<Pipelines>> get(const Gpu& gpu, const Pipelines::Config& config);

  /// Drops all pipelines. Call it before a device is destroyed.
  void clear() { kept_.clear(); }

 private:
  struct Kept {
    const Gpu* gpu;
    Sampling sampling;
    std::shared_ptr<Pipelines> pipelines;
  };
  std::vector<Kept> kept_;
};

}  // namespace fanlight
