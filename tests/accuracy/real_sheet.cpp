// SPDX-License-Identifier: Apache-2.0
// The liver sweep of the user guide as a person sees it: how whole the largest sheet of the picture is, and
// whether it lies at the strongest echo. Three views beside each other: the default for its geometry, the 16
// options that an expert once tuned by hand, and auto_scene(). Fails if
// auto_scene()'s sheet is less whole than the one tuned by hand, a fifth smaller, or less than four fifths of
// it lie at the echo.
//   real_sheet RECORDING GEOMETRY.toml
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "acquisition/offline_volumes.hpp"
#include "renderer/survey/auto_scene.hpp"
#include "tests/accuracy/depth_rig.hpp"
#include "tests/support/pixel_rays.hpp"
#include "tests/support/twin_echo.hpp"

namespace fanlight::test {
namespace {

constexpr PictureSize kSheetPicture{512, 512};
constexpr double kNearEchoMm = 5;
constexpr double kLeastNearEcho = 0.8;
constexpr double kLeastSize = 0.8;  // of the sheet tuned by hand
constexpr double kSearchMm = 20;
constexpr double kEchoStepMm = 0.5;
constexpr int kEchoMean = 4;  // steps: a single speckle is not the strongest echo

struct View {
  std::string name;
  Scene scene;
};

struct SheetFigures {
  double surface_share = 0;    // of the pixels
  double largest_cm2 = 0;      // of the largest part that hangs together, as the picture shows it
  double whole_share = 0;      // of the pixels with a surface, in that part
  double near_echo_share = 0;  // of that part, within 5 mm of its ray's strongest echo
};

/// The pixels of the largest part of the depth map whose neighbours (of four) all have a surface and rise by
/// less than two millimetres a pixel.
std::vector<std::size_t> largest_part(const std::vector<float>& depths_mm) {
  constexpr float kMostRiseMm = 2;
  const int width = static_cast<int>(kSheetPicture.width);
  const int height = static_cast<int>(kSheetPicture.height);
  std::vector<bool> seen(depths_mm.size(), false);
  std::vector<std::size_t> largest;
  for (std::size_t seed = 0; seed < depths_mm.size(); ++seed) {
    if (seen[seed] || depths_mm[seed] < 0) continue;
    std::vector<std::size_t> part = {seed};
    seen[seed] = true;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const int column = static_cast<int>(part[next]) % width;
      const int row = static_cast<int>(part[next]) / width;
      for (const auto& [right, down] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const int to_column = column + right;
        const int to_row = row + down;
        if (to_column < 0 || to_column >= width || to_row < 0 || to_row >= height) continue;
        const auto to = static_cast<std::size_t>(to_row * width + to_column);
        if (seen[to] || depths_mm[to] < 0) continue;
        if (std::abs(depths_mm[to] - depths_mm[part[next]]) >= kMostRiseMm) continue;
        seen[to] = true;
        part.push_back(to);
      }
    }
    if (part.size() > largest.size()) largest = std::move(part);
  }
  return largest;
}

/// Depth of the strongest echo along a ray within kSearchMm of its surface, a mean over two millimetres, mm.
/// The same search for all views: the rays of each begin and end elsewhere.
double strongest_echo_mm(const Volume& volume, const PixelRays& rays, std::size_t pixel, double surface_mm) {
  const PixelRay ray = rays.ray(static_cast<std::uint32_t>(pixel % kSheetPicture.width),
                                static_cast<std::uint32_t>(pixel / kSheetPicture.width));
  const Scene::Speckle unfiltered{.filter = SpeckleFilter::kNone};
  std::vector<double> echoes;
  double best = 0;
  double best_mm = HUGE_VAL;
  for (double depth_mm = surface_mm - kSearchMm; depth_mm <= surface_mm + kSearchMm;
       depth_mm += kEchoStepMm) {
    echoes.push_back(twin_echo(unfiltered, volume, ray.at(depth_mm)).value_or(0));
    if (echoes.size() < kEchoMean) continue;
    double mean = 0;
    for (auto each = echoes.end() - kEchoMean; each != echoes.end(); ++each) mean += *each / kEchoMean;
    if (mean > best) {
      best = mean;
      best_mm = depth_mm - kEchoStepMm * (kEchoMean - 1) / 2.0;
    }
  }
  return best_mm;
}

SheetFigures figures_of(const Volume& volume, const Scene& scene, const std::vector<float>& depths_mm) {
  const std::vector<std::size_t> part = largest_part(depths_mm);
  const PixelRays rays(scene, kSheetPicture);
  double looked_at = 0;
  double near_echo = 0;
  for (std::size_t i = 0; i < part.size(); i += 5) {  // enough for two digits
    const double echo_mm = strongest_echo_mm(volume, rays, part[i], depths_mm[part[i]]);
    ++looked_at;
    near_echo += std::abs(depths_mm[part[i]] - echo_mm) <= kNearEchoMm ? 1 : 0;
  }
  const auto surface =
      static_cast<double>(std::ranges::count_if(depths_mm, [](float depth) { return depth >= 0; }));
  if (part.empty()) return {};
  const double pixel_mm = rays.port().pixel_mm;
  return {.surface_share = surface / static_cast<double>(depths_mm.size()),
          .largest_cm2 = static_cast<double>(part.size()) * pixel_mm * pixel_mm / 100,
          .whole_share = static_cast<double>(part.size()) / surface,
          .near_echo_share = near_echo / looked_at};
}

/// The scene with NAME=VALUE settings. Throws std::runtime_error.
Scene with(Scene scene, std::initializer_list<std::pair<std::string_view, std::string_view>> settings) {
  for (const auto& [name, value] : settings) {
    const SceneField* const field = find_scene_field(name);
    if (field == nullptr) throw std::runtime_error(fmt::format("there is no field {}", name));
    if (auto set = set_field(scene, *field, value); !set) throw std::runtime_error(set.error().message);
  }
  return scene;
}

/// What the README told to type before there was auto_scene().
Scene tuned_by_hand(const Scene& suggested) {
  return with(suggested, {{"detector.window", "32"},
                          {"detector.threshold", "28"},
                          {"filter.size", "25"},
                          {"filter.islands", "15"},
                          {"filter.holes", "13"},
                          {"camera.yaw_deg", "-40"},
                          {"camera.pitch_deg", "38"},
                          {"camera.distance_mm", "37"},
                          {"camera.field_mm", "115"},
                          {"rays.end_mm", "105"},
                          {"camera.target_x_mm", "8"},
                          {"camera.target_y_mm", "123"},
                          {"camera.target_z_mm", "-25"},
                          {"light.right_mm", "-60"},
                          {"light.up_mm", "-30"},
                          {"light.depth_mm", "-40"}});
}

/// Prints the figures; false if auto_scene()'s sheet is less whole or less at the echo than is demanded.
bool compare(const Volume& volume, DepthRig& rig, const Scene& suggested) {
  const auto automatic = auto_scene(volume, suggested, kSheetPicture);
  if (!automatic) throw std::runtime_error("auto_scene() found no surface, expected the diaphragm");
  fmt::print("{:<14} {:>10} {:>17} {:>16} {:>19}\n", "", "surface %", "largest part cm2", "% of the surface",
             "% near the echo");
  std::vector<SheetFigures> all;
  for (const View& view : {View{"default", suggested}, View{"tuned by hand", tuned_by_hand(suggested)},
                           View{"auto", automatic->scene}}) {
    const SheetFigures figures = figures_of(volume, view.scene, rig.depths(view.scene).smooth_mm);
    fmt::print("{:<14} {:>10.1f} {:>17.1f} {:>16.1f} {:>19.1f}\n", view.name, 100 * figures.surface_share,
               figures.largest_cm2, 100 * figures.whole_share, 100 * figures.near_echo_share);
    all.push_back(figures);
  }
  const SheetFigures& by_hand = all[1];
  const SheetFigures& found = all[2];
  const bool whole =
      found.whole_share >= by_hand.whole_share && found.largest_cm2 >= kLeastSize * by_hand.largest_cm2;
  const bool at_the_echo = found.near_echo_share >= kLeastNearEcho;
  if (!whole) fmt::print("the sheet of auto is less whole, or smaller, than the one tuned by hand\n");
  if (!at_the_echo)
    fmt::print("less than {:.0f} % of auto's sheet lies near the strongest echo\n", 100 * kLeastNearEcho);
  return whole && at_the_echo;
}

int run(const std::string& recording, const std::string& geometry_path) {
  Doorbell bell;
  ProbeLink no_probe(bell, bell);
  auto source =
      open_source(recording, {.geometry_path = geometry_path, .pace = SourcePace::kAsFastAsTaken}, no_probe);
  if (!source) throw std::runtime_error(source.error().message);
  const SourceDescription& description = (*source)->description();
  OfflineVolumes volumes(**source);
  const auto volume = volumes.pick(std::nullopt);
  if (!volume) throw std::runtime_error(volume.error().message);
  BareGpu bare("");
  DepthRig rig(bare, {description.geometry, description.first_angle_rad, description.last_angle_rad},
               description.frames_per_volume, kSheetPicture);
  rig.set_volume(**volume);
  return compare(**volume, rig,
                 scene_for(description.geometry, description.first_angle_rad, description.last_angle_rad,
                           kSheetPicture.height))
             ? 0
             : 1;
}

}  // namespace
}  // namespace fanlight::test

int main(int count, char** arguments) {
  if (count != 3) {
    fmt::print(stderr, "usage: real_sheet RECORDING GEOMETRY.toml\n");
    return 2;
  }
  try {
    return fanlight::test::run(arguments[1], arguments[2]);
  } catch (const std::exception& failure) {
    fmt::print(stderr, "real_sheet: {}\n", failure.what());
    return 1;
  }
}
