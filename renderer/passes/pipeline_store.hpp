// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "renderer/passes/pipelines.hpp"

namespace fanlight {

/// Keeps the pipelines of a device for the next renderer on it, which then need not build them: that takes
/// the driver of a processor about a second. Outlives its renderers; the devices outlive it. One thread.
class PipelineStore {
 public:
  /// The pipelines of that device and sampling; built, with the cache of `config`, where there are none yet.
  /// Error: a pipeline that cannot be built.
  Result<std::shared_ptr<Pipelines>> get(const Gpu& gpu, const Pipelines::Config& config);

  /// Forgets all, before the devices end.
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
