// SPDX-License-Identifier: Apache-2.0
#include "server/bench/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/bench/rig.hpp"
#include "server/bench/volumes.hpp"

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

void turn_camera(Scene& scene, double sign) {
  scene.camera.yaw_deg += sign;
}

void move_light(Scene& scene, double sign) {
  scene.light.right_mm += sign;
}

double cast_ms(const Picture& picture) {
  return picture.stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)];
}

}  // namespace

Result<BenchTimes> run_bench_row(const RenderDevice& device, const BenchRow& row, int rounds) {
  constexpr std::uint32_t kVolumes = 3;
  auto volumes = BenchVolumes::create(row, kVolumes);
  if (!volumes) return volumes.error();
  const auto scene = bench_scene(row, volumes->description());
  if (!scene) return scene.error();
  BenchRig rig(device, *volumes, *scene, row.picture);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  BenchRig unskipped(device, *volumes, *scene, row.picture);
  if (auto started = unskipped.start(Skipping::kOff); !started) return started.error();

  Scene with_every_frame = *scene;
  with_every_frame.refresh = Refresh::kFrame;
  BenchRig rolling(device, *volumes, with_every_frame, row.picture);
  if (auto started = rolling.start(Skipping::kOn); !started) return started.error();
  if (auto first = rolling.whole_volume(); !first) return first.error();

  BenchTimes times;
  const auto note = [&](int round, const char* name, double ms) {
    if (round > 0) times.ms[name].push_back(ms);
  };
  for (int round = 0; round <= rounds; ++round) {
    const auto whole = rig.whole_volume();
    if (!whole) return whole.error();
    note(round, "whole_volume", *whole);
    note(round, "whole_prepare", rig.picture().stamp.stage_ms[static_cast<std::size_t>(Stage::kPrepare)]);
    const auto newest = rig.new_volume();
    if (!newest) return newest.error();
    note(round, "new_volume", *newest);
    for (std::size_t stage = 0; stage < kStages; ++stage) {
      note(round, kStageNames[stage].data(), rig.picture().stamp.stage_ms[stage]);
    }
    const auto camera = rig.change(turn_camera);
    if (!camera) return camera.error();
    note(round, "camera", *camera);
    const auto light = rig.change(move_light);
    if (!light) return light.error();
    note(round, "light_moved", *light);
    const auto frames = rolling.rolling_sweep();
    if (!frames) return frames.error();
    for (const double ms : *frames) note(round, "frame", ms);
    const auto plain = unskipped.whole_volume();
    if (!plain) return plain.error();
    note(round, "cast_unskipped", cast_ms(unskipped.picture()));
  }
  const auto depths = rig.renderer().read_depth();
  if (!depths) return depths.error();
  const auto surfaces = std::ranges::count_if(depths->smooth_mm, [](float depth) { return depth >= 0; });
  times.surface_share = static_cast<double>(surfaces) / static_cast<double>(depths->smooth_mm.size());
  return times;
}

Result<Scene> bench_scene(const BenchRow& row, const SourceDescription& source) {
  const auto scene = applied(scene_for(source.geometry, source.first_angle_rad, source.last_angle_rad,
                                       static_cast<std::uint32_t>(row.picture)),
                             row.method);
  return scene ? applied(*scene, row.settings) : scene;
}

double quantile(std::vector<double> times_ms, double share) {
  std::ranges::sort(times_ms);
  const double place = share * static_cast<double>(times_ms.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, times_ms.size() - 1);
  return std::lerp(times_ms[below], times_ms[above], place - static_cast<double>(below));
}

}  // namespace fanlight
