// SPDX-License-Identifier: Apache-2.0
#include "renderer/pipelines/pipeline_store.hpp"

#include <algorithm>
#include <future>
#include <utility>

namespace fanlight {

std::shared_ptr<Pipelines> PipelineStore::find(const Wanted& wanted) const {
  const auto known = std::ranges::find_if(kept_, [&](const Kept& kept) {
    return kept.gpu == &wanted.gpu && kept.pipelines->sampling() == wanted.config.sampling &&
           kept.pipelines->lights() == wanted.config.lights;
  });
  return known == kept_.end() ? nullptr : known->pipelines;
}

Result<std::shared_ptr<Pipelines>> PipelineStore::keep(const Wanted& wanted,
                                                       Result<std::unique_ptr<Pipelines>> made) {
  if (!made) return made.error();
  return kept_.emplace_back(Kept{&wanted.gpu, *std::move(made)}).pipelines;
}

Result<std::shared_ptr<Pipelines>> PipelineStore::get(const Gpu& gpu, const Pipelines::Config& config) {
  const Wanted wanted{gpu, config};
  if (auto known = find(wanted)) return known;
  return keep(wanted, Pipelines::create(gpu, config));
}

Result<std::pair<std::shared_ptr<Pipelines>, std::shared_ptr<Pipelines>>> PipelineStore::get(
    const Wanted& first, const Wanted& second) {
  std::future<Result<std::unique_ptr<Pipelines>>> building;
  if (!find(second)) building = std::async([&] { return Pipelines::create(second.gpu, second.config); });
  auto pipelines = get(first.gpu, first.config);
  auto others = building.valid() ? keep(second, building.get()) : find(second);
  if (!pipelines) return pipelines.error();
  if (!others) return others.error();
  return std::pair(*std::move(pipelines), *std::move(others));
}

}  // namespace fanlight
