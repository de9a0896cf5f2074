// SPDX-License-Identifier: Apache-2.0
#include "server/bench/run.hpp"

#include <algorithm>
#include <cmath>

#include "server/bench/rig.hpp"
#include "server/bench/work.hpp"

namespace fanlight {

namespace {

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
  auto work = BenchWork::create(row, kVolumes);
  if (!work) return work.error();
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  BenchRig unskipped(device, *work);
  if (auto started = unskipped.start(Skipping::kOff); !started) return started.error();

  work->scene.refresh = Refresh::kFrame;
  BenchRig rolling(device, *work);
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
  times.surface_share = rig.picture().stamp.surface_share;
  return times;
}

double quantile(std::vector<double> times_ms, double share) {
  if (times_ms.empty()) return 0;
  std::ranges::sort(times_ms);
  const double place = share * static_cast<double>(times_ms.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, times_ms.size() - 1);
  return std::lerp(times_ms[below], times_ms[above], place - static_cast<double>(below));
}

}  // namespace fanlight
