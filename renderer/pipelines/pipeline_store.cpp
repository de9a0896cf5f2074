// SPDX-License-Identifier: Apache-2.0
#include "renderer/pipelines/pipeline_store.hpp"

#include <algorithm>
#include <utility>

namespace fanlight {

Result<std::shared_ptr<Pipelines>> PipelineStore::get(const Gpu& gpu, const Pipelines::Config& config) {
  const auto known = std::ranges::find_if(
      kept_, [&](const Kept& kept) { return kept.gpu == &gpu && kept.sampling == config.sampling; });
  if (known != kept_.end()) return known->pipelines;
  auto made = Pipelines::create(gpu, config);
  if (!made) return made.error();
  return kept_.emplace_back(Kept{&gpu, config.sampling, *std::move(made)}).pipelines;
}

}  // namespace fanlight
