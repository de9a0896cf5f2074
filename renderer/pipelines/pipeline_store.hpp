// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "renderer/pipelines/pipelines.hpp"

namespace fanlight {

/// Keeps the pipelines of a device for the next renderer on it, so that it does not build them again, which
/// takes a second or more on a processor. Keeps every variant that was asked for (detector window, mode, kind
/// of frames) until clear(). Must outlive its renderers; the devices must outlive it. One thread.
class PipelineStore {
 public:
  /// The pipelines of a device for a sampling and for its passes (Config::lights). The first call for them
  /// builds them with the cache of `config`; later calls ignore that cache. Error: a pipeline that cannot be
  /// built.
  Result<std::shared_ptr<Pipelines>> get(const Gpu& gpu, const Pipelines::Config& config);

  struct Wanted {
    const Gpu& gpu;
    const Pipelines::Config& config;
  };
  /// The same for two devices. Builds those of the second one on another thread meanwhile.
  Result<std::pair<std::shared_ptr<Pipelines>, std::shared_ptr<Pipelines>>> get(const Wanted& first,
                                                                                const Wanted& second);

  /// Drops all pipelines. Call it before a device is destroyed.
  void clear() { kept_.clear(); }

 private:
  struct Kept {
    const Gpu* gpu;
    std::shared_ptr<Pipelines> pipelines;
  };
  std::shared_ptr<Pipelines> find(const Wanted& wanted) const;
  Result<std::shared_ptr<Pipelines>> keep(const Wanted& wanted, Result<std::unique_ptr<Pipelines>> made);

  std::vector<Kept> kept_;
};

}  // namespace fanlight
