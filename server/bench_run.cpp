#include "server/bench_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "proto/clock.hpp"
#include "renderer/renderer.hpp"
#include "server/bench_volumes.hpp"

namespace fanlight {

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

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

/// A renderer, the volumes that it is shown, and a clock.
class BenchRig {
 public:
  BenchRig(const Gpu& gpu, BenchVolumes& volumes, const Scene& scene, int picture)
      : gpu_(gpu), volumes_(volumes), scene_{.revision = 1, .scene = scene}, picture_(picture) {}

  Result<void> start(Skipping skipping) {
    const SourceDescription& source = volumes_.description();
    const auto side = static_cast<std::uint32_t>(picture_);
    auto made = Renderer::create({.size = {side, side},
                                  .geometry = source.geometry,
                                  .first_angle_rad = source.first_angle_rad,
                                  .last_angle_rad = source.last_angle_rad,
                                  .frame_capacity = volumes_.frame_capacity(),
                                  .skipping = skipping},
                                 {.gpu = gpu_, .counters = counters_}, scene_);
    if (!made) return made.error();
    renderer_ = std::move(*made);
    return {};
  }

  /// From the call to the finished picture, ms.
  Result<double> whole_volume() {
    const Volume& volume = volumes_.next();
    const std::int64_t from_ns = now_ns();
    if (auto loaded = renderer_->load(volume); !loaded) return loaded.error();
    return picture_since(from_ns);
  }

  /// The same, with all frames but the last there before.
  Result<double> new_volume() {
    const Volume& volume = volumes_.next();
    const std::uint32_t frames = volume.stamp().frames;
    for (std::uint32_t index = 0; index + 1 < frames; ++index) {
      if (auto taken = take(index); !taken) return taken.error();
    }
    const std::int64_t from_ns = now_ns();
    if (auto loaded = renderer_->load(volume); !loaded) return loaded.error();
    return picture_since(from_ns);
  }

  /// Each frame of the next sweep as it comes, from the call to the picture that shows it, ms.
  Result<std::vector<double>> rolling_sweep() {
    std::vector<double> each_ms;
    const Volume& volume = volumes_.next();
    for (std::uint32_t index = 0; index < volume.stamp().frames; ++index) {
      const std::int64_t from_ns = now_ns();
      renderer_->take_frame(volumes_.frame(index));
      if (auto advanced = renderer_->advance(); !advanced) return advanced.error();
      if (!renderer_->busy()) continue;  // it has no place in the last sweep, and comes with its volume
      const auto picture_ms = picture_since(from_ns);
      if (!picture_ms) return picture_ms.error();
      each_ms.push_back(*picture_ms);
    }
    return each_ms;
  }

  Result<double> change(void (*how)(Scene&, double sign)) {
    sign_ = -sign_;
    how(scene_.scene, sign_);
    ++scene_.revision;
    const std::int64_t from_ns = now_ns();
    renderer_->show(scene_);
    return picture_since(from_ns);
  }

  const Picture& picture() const { return shown_; }
  Renderer& renderer() { return *renderer_; }

 private:
  Result<void> take(std::uint32_t index) {
    while (!renderer_->wants_frame()) {
      if (auto waited = renderer_->wait(kSecondNs); !waited) return waited;
    }
    renderer_->take_frame(volumes_.frame(index));
    if (auto advanced = renderer_->advance(); !advanced) return advanced;
    return renderer_->wait(kSecondNs);
  }

  Result<double> picture_since(std::int64_t from_ns) {
    for (;;) {
      if (auto advanced = renderer_->advance(); !advanced) return advanced.error();
      if (renderer_->collect(shown_)) return static_cast<double>(now_ns() - from_ns) / 1e6;
      if (!renderer_->busy()) return Error{ErrorCode::kUnavailable, "no picture came of what was shown"};
      if (auto waited = renderer_->wait(kSecondNs); !waited) return waited.error();
    }
  }

  const Gpu& gpu_;
  BenchVolumes& volumes_;
  NumberedScene scene_;
  int picture_;
  double sign_ = 1;
  RenderCounters counters_;
  std::unique_ptr<Renderer> renderer_;
  Picture shown_;
};

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

Result<BenchTimes> run_bench_row(const Gpu& gpu, const BenchRow& row, int rounds) {
  constexpr std::uint32_t kVolumes = 3;
  auto volumes = BenchVolumes::create(std::string(row.input), kVolumes);
  if (!volumes) return volumes.error();
  const auto scene = bench_scene(row, volumes->description());
  if (!scene) return scene.error();
  BenchRig rig(gpu, *volumes, *scene, row.picture);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  BenchRig unskipped(gpu, *volumes, *scene, row.picture);
  if (auto started = unskipped.start(Skipping::kOff); !started) return started.error();

  Scene with_every_frame = *scene;
  with_every_frame.refresh = Refresh::kFrame;
  BenchRig rolling(gpu, *volumes, with_every_frame, row.picture);
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
  return applied(scene_for(source.geometry, source.first_angle_rad, source.last_angle_rad,
                           static_cast<std::uint32_t>(row.picture)),
                 row.settings);
}

double quantile(std::vector<double> times_ms, double share) {
  std::ranges::sort(times_ms);
  const double place = share * static_cast<double>(times_ms.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, times_ms.size() - 1);
  return std::lerp(times_ms[below], times_ms[above], place - static_cast<double>(below));
}

}  // namespace fanlight
