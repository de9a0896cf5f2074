// SPDX-License-Identifier: Apache-2.0
#include "server/bench/work.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "acquisition/source/suggested_scene.hpp"

namespace fanlight {

namespace {

Result<Scene> applied(Scene scene, std::string_view settings) {
  while (!settings.empty()) {
    const std::string_view item = settings.substr(0, settings.find(' '));
    settings.remove_prefix(std::min(item.size() + 1, settings.size()));
    if (item.empty()) continue;
    const std::string_view name = item.substr(0, item.find('='));
    const SceneField* const field = find_scene_field(name);
    if (field == nullptr) {
      return Error{ErrorCode::kInvalidArgument, fmt::format("there is no field {} in a scene", name)};
    }
    if (auto set = set_field(scene, *field, item.substr(name.size() + 1)); !set) return set.error();
  }
  return scene;
}

}  // namespace

Result<BenchWork> BenchWork::create(const BenchRow& row, std::uint32_t count) {
  auto volumes = BenchVolumes::create(row, count);
  if (!volumes) return volumes.error();
  const SourceDescription& source = volumes->description();
  auto scene = applied(suggested_scene(source, static_cast<std::uint32_t>(row.picture)), row.method);
  if (scene) scene = applied(*scene, row.settings);
  if (scene) scene = applied(*scene, row.changes);
  if (!scene) return scene.error();
  return BenchWork{.volumes = std::move(*volumes), .scene = *scene, .picture = row.picture};
}

}  // namespace fanlight
