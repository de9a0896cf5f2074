// SPDX-License-Identifier: Apache-2.0
#include "tests/gpu/seeded_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

namespace fanlight::test {

namespace {

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : random_(seed) {}

  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  int whole(int low, int high) { return std::uniform_int_distribution(low, high)(random_); }
  bool one_in(int many) { return whole(1, many) == 1; }
  /// Side of a window.
  int odd(int low, int high) { return 2 * whole(low / 2, high / 2) + 1; }
  /// One of an enum's values, of which this is the last.
  template <typename Enum>
  Enum any_to(Enum last) {
    return static_cast<Enum>(whole(0, static_cast<int>(last)));
  }

 private:
  std::mt19937 random_;
};

FanGeometry made_geometry(Dice& dice) {
  FanGeometry geometry{.kind = dice.any_to(FrameKind::kLinearLines),
                       .columns = 72,
                       .rows = 88,
                       .pixel_width_mm = dice.between(0.4, 0.9),
                       .pixel_height_mm = dice.between(0.4, 0.9),
                       .face_column = dice.between(28, 44),
                       .face_row = dice.between(-2, 5),
                       .motor_radius_mm = dice.between(10, 40),
                       .probe_radius_mm = dice.between(15, 40)};
  if (geometry.kind == FrameKind::kConvexLines) geometry.line_pitch_deg = dice.between(0.5, 1.1);
  if (geometry.kind == FrameKind::kCartesian && dice.one_in(2)) {
    geometry.sector.half_angle_deg = dice.between(25, 40);
    if (dice.one_in(2)) {
      geometry.sector.reach_mm = geometry.probe_radius_mm + dice.between(0.85, 1.1) * geometry.depth_mm();
    }
  }
  return geometry;
}

std::vector<double> made_angles(Dice& dice) {
  std::vector<double> angles_rad;
  const bool even = dice.one_in(4);
  double angle_rad = radians(dice.between(-40, -25));
  for (int frame = 0; frame < 24; ++frame) {
    angles_rad.push_back(angle_rad);
    angle_rad += radians(even ? 2.5 : dice.between(1.0, 4.0));
  }
  if (dice.one_in(2)) std::ranges::reverse(angles_rad);
  if (dice.one_in(6)) std::swap(angles_rad[7], angles_rad[8]);  // an irregular hand-guided sweep
  return angles_rad;
}

/// Tissue below an undulating surface. Its grey level rises smoothly over 1 to 2 mm.
struct Body {
  double depth_mm = 0;
  double ripple_mm = 0;
  double ledge_mm = 0;   ///< additional depth of the marked side
  double crumbs_mm = 0;  ///< radius of small balls in front of the surface, and of pits in it; 0: none
  double noise = 0;      ///< grey levels
  bool bright_fluid = false;

  /// Depth of a point below the surface; negative in the fluid.
  double below_mm(const Point& at) const {
    double surface_mm = depth_mm + 3 * std::sin(at.x_mm / ripple_mm) + 3 * std::cos(at.z_mm / ripple_mm);
    if (ledge_mm > 0) surface_mm += 0.5 * ledge_mm * (1 + std::tanh((at.x_mm - 4) / 0.8));
    double below_mm = at.y_mm - surface_mm;
    if (crumbs_mm == 0) return below_mm;
    constexpr double kApartMm = 17;
    // The nearest ball of a grid; every second one is a pit.
    const double across = std::round(at.x_mm / kApartMm);
    const double up = std::round(at.z_mm / kApartMm);
    const double aside_mm = std::hypot(at.x_mm - across * kApartMm, at.z_mm - up * kApartMm);
    if (std::fmod(std::abs(across + up), 2) == 1) return std::min(below_mm, aside_mm - crumbs_mm);
    constexpr double kBeforeMm = 13;
    return std::max(below_mm, crumbs_mm - std::hypot(aside_mm, at.y_mm - depth_mm + kBeforeMm));
  }

  double grey(const Point& at) const {
    const double tissue = 1 / (1 + std::exp(-1.5 * below_mm(at)));
    return 20 + 130 * (bright_fluid ? 1 - tissue : tissue);
  }
};

std::function<double(const Point&)> noisy(const Body& body, std::uint32_t seed) {
  if (body.noise == 0) return [body](const Point& at) { return body.grey(at); };
  return [body, random = std::mt19937(seed)](const Point& at) mutable {
    return body.grey(at) + std::normal_distribution(0.0, body.noise)(random);
  };
}

/// The same inside a wedge about the middle of the frames, 0 (not scanned) outside.
std::function<double(const Point&)> within_wedge(Dice& dice, std::function<double(const Point&)> grey) {
  return [grey = std::move(grey), slope = dice.between(0.3, 0.6), near_mm = dice.between(2, 8),
          apex_mm = dice.between(10, 30)](const Point& at) {
    const double value = std::max(1.0, grey(at));
    return std::abs(at.x_mm) < slope * (at.y_mm + apex_mm) && at.y_mm > near_mm ? value : 0;
  };
}

Body made_body(Dice& dice, const FanGeometry& geometry) {
  Body body{.depth_mm = dice.between(0.5, 0.8) * geometry.depth_mm(), .ripple_mm = dice.between(5, 12)};
  if (dice.one_in(3)) body.ledge_mm = dice.between(4, 9);
  if (dice.one_in(3)) body.crumbs_mm = dice.between(1.5, 3.5);
  if (dice.one_in(3)) body.noise = dice.between(1, 6);
  return body;
}

void set_camera(Dice& dice, Scene& scene) {
  scene.camera.yaw_deg += dice.between(-25, 25);
  scene.camera.pitch_deg += dice.between(-25, 25);
  scene.camera.roll_deg = dice.between(-180, 180);
  scene.camera.field_mm *= dice.between(0.5, 0.9);
  scene.camera.projection = dice.any_to(Projection::kPerspective);
  // With a wide opening the eye lies within the fan.
  scene.camera.opening_deg = dice.one_in(5) ? dice.between(70, 100) : dice.between(10, 60);
  scene.rays.start_mm = dice.between(0, 8);
  scene.rays.end_mm *= dice.between(0.95, 1.2);
  if (dice.one_in(4)) scene.rays.step_mm = dice.between(0.3, 0.8);
  if (dice.one_in(4)) scene.rays.window = !dice.one_in(5) ? 3 : dice.one_in(2) ? 7 : 5;
}

/// A clip plane near a point, which stays visible.
Scene::Clip made_clip(Dice& dice, const Point& within) {
  Scene::Clip clip{
      .normal_x = dice.between(-1, 1), .normal_y = dice.between(-1, 1), .normal_z = dice.between(-1, 1)};
  const double length = std::hypot(clip.normal_x, clip.normal_y, clip.normal_z);
  clip.distance_mm =
      (clip.normal_x * within.x_mm + clip.normal_y * within.y_mm + clip.normal_z * within.z_mm) / length -
      dice.between(5, 20);
  return clip;
}

TransferFunction made_transfer(Dice& dice) {
  std::string text;
  int level = dice.whole(0, 60);
  for (int left = dice.whole(2, 5); left > 0; --left) {
    text += fmt::format("{}{} #{:06x} {:.3f}", text.empty() ? "" : ", ", level, dice.whole(0, 0xffffff),
                        dice.one_in(4) ? 0.0 : dice.between(0, 0.3));
    level += dice.whole(10, 45);
  }
  const auto transfer = TransferFunction::parse(text);
  if (!transfer) throw std::runtime_error(transfer.error().message);
  return *transfer;
}

void set_slices(Dice& dice, const Point& within, Scene& scene) {
  const ViewFrame view = view_frame(scene.camera);
  const glm::dvec3 at(within.x_mm, within.y_mm, within.z_mm);
  scene.slice.depth_mm = glm::dot(at - view.centre, view.forward) + dice.between(-4, 4);
  scene.transfer = made_transfer(dice);
}

void cut(Dice& dice, const Point& within, Scene& scene) {
  if (dice.one_in(4)) {
    scene.crop = {.left_mm = within.x_mm - dice.between(10, 30),
                  .right_mm = within.x_mm + dice.between(10, 30),
                  .near_mm = within.y_mm - dice.between(4, 12),
                  .far_mm = within.y_mm + dice.between(4, 12),
                  .below_mm = within.z_mm - dice.between(10, 30),
                  .above_mm = within.z_mm + dice.between(10, 30)};
  }
  if (dice.one_in(4)) scene.clip1 = made_clip(dice, within);
  if (dice.one_in(4)) scene.clip2 = made_clip(dice, within);
}

std::string words(const glm::dvec3& vector) {
  return fmt::format("{:.6f} {:.6f} {:.6f}", vector.x, vector.y, vector.z);
}

/// Nine corners around the drawn point `about`.
std::string made_outline(Dice& dice, const glm::dvec2& about, double least_mm, double most_mm) {
  std::string text;
  for (int corner = 0; corner < 9; ++corner) {
    const double angle_rad = (corner + dice.between(-0.4, 0.4)) * 2 * std::numbers::pi / 9;
    const double radius_mm = dice.between(least_mm, most_mm);
    text += fmt::format(" {:.2f} {:.2f}", about.x + radius_mm * std::cos(angle_rad),
                        about.y + radius_mm * std::sin(angle_rad));
  }
  return text;
}

/// Lassos and balls about a point, as a user draws them who looks from anywhere.
CutList made_cuts(Dice& dice, const Point& within, const Scene& scene) {
  std::string text;
  for (int left = dice.whole(1, 3); left > 0; --left) {
    if (!text.empty()) text += "; ";
    const glm::dvec3 at(within.x_mm + dice.between(-8, 8), within.y_mm + dice.between(-4, 4),
                        within.z_mm + dice.between(-8, 8));
    if (dice.one_in(3)) {
      text +=
          fmt::format("balls {:.2f} at {} {}", dice.between(2, 9), words(at), words(at + dice.between(2, 6)));
      continue;
    }
    Scene::Camera camera = scene.camera;
    camera.yaw_deg += dice.between(-40, 40);
    const ViewFrame view = view_frame(camera);
    const glm::dvec3 from = at - view.centre;
    const double depth_mm = glm::dot(from, view.forward);
    const double eye_mm = dice.one_in(2) ? 0 : dice.between(30, 200);
    const double scale = eye_mm > 0 ? (depth_mm + eye_mm) / eye_mm : 1;
    const glm::dvec2 drawn(glm::dot(from, view.right) / scale, glm::dot(from, view.up) / scale);
    // Enough of the surface must remain.
    const bool outside = dice.one_in(4);
    const double reach_mm = dice.one_in(2) ? 3000 : depth_mm + dice.between(-3, 6);
    text += fmt::format("{} -3000 {:.2f} from {} right {} up {} eye {:.2f} outline{}",
                        outside ? "outside" : "inside", reach_mm, words(view.centre), words(view.right),
                        words(view.up), eye_mm,
                        outside ? made_outline(dice, drawn, 12, 35) : made_outline(dice, drawn, 2, 12));
  }
  auto list = CutList::parse(text);
  if (!list) throw std::runtime_error(list.error().message);
  return *list;
}

void set_detector(Dice& dice, Body& body, double finest_mm, Scene& scene) {
  // The twins know samples and pixels alone; effective_scene() has tests of its own.
  scene.detector.window_mm = 0;
  scene.filter.size_mm = 0;
  scene.speckle = {.filter = SpeckleFilter::kNone};
  if (dice.one_in(2)) {
    scene.speckle = {.filter = dice.any_to(SpeckleFilter::kGuided),
                     .size = dice.odd(3, 7),
                     .across = dice.odd(1, 3),
                     .noise = dice.between(0.05, 0.6)};
    if (dice.one_in(3)) {
      scene.speckle.noise = 0;
      scene.speckle.levels = dice.between(3, 40);
    }
  }
  Scene::Detector& detector = scene.detector;
  detector.sign = dice.any_to(EdgeSign::kEither);
  detector.place = dice.any_to(SurfacePlace::kLevel);
  detector.rise = dice.between(0.2, 0.95);
  detector.sheet_below = 60 * (1 - detector.rise);
  detector.reach = dice.one_in(3) ? 0 : dice.between(0.1, 1);
  detector.least_tissue = dice.between(1, 145);
  // Noise must not create surfaces.
  detector.window = 2 * dice.whole(body.noise > 0 ? 6 : 1, 16);
  detector.threshold = body.noise > 0 ? dice.between(30, 45) : dice.between(12, 40);
  // A short window covers only a part of an edge, which pass 0 and the ray's window widen further.
  const double step_mm = scene.rays.step_mm > 0 ? scene.rays.step_mm : finest_mm;
  detector.threshold *= std::min(1.0, 0.12 * detector.window * step_mm);
  body.bright_fluid =
      detector.sign == EdgeSign::kBrightToDark || (detector.sign == EdgeSign::kEither && dice.one_in(2));
}

void set_filter(Dice& dice, Scene::Filter& filter) {
  filter = {.kind = dice.any_to(DepthFilter::kEdgePreserving),
            .size = dice.odd(1, 31),
            .weights = dice.any_to(FilterWeights::kConfidence),
            .step_mm = dice.between(0.5, 6),
            .islands = dice.one_in(2) ? dice.odd(3, 15) : 1,
            .holes = dice.one_in(2) ? dice.odd(3, 15) : 1,
            .steady = dice.one_in(3) ? dice.between(0.1, 0.95) : 0,
            .seam_frames = 0};
}

void set_light(Dice& dice, Scene& scene) {
  scene.light = {.kind = dice.any_to(LightKind::kDirectional),
                 .right_mm = dice.between(-60, 60),
                 .up_mm = dice.between(-60, 60),
                 .depth_mm = dice.between(-50, 50),
                 .red = dice.between(0.5, 1),
                 .green = dice.between(0.5, 1),
                 .blue = dice.between(0.5, 1),
                 .ambient = dice.between(0, 0.3),
                 .diffuse = dice.between(0.4, 1),
                 .specular = dice.between(0, 0.6),
                 .shininess = dice.between(1, 60),
                 .normals = dice.any_to(Normals::kCentral),
                 .occlusion = dice.one_in(2) ? dice.between(0.1, 1) : 0,
                 .occlusion_mm = dice.between(0.5, 20),
                 .fade_mm = dice.one_in(3) ? dice.between(0.1, 10) : 0,
                 .rim = dice.one_in(2) ? dice.between(0, 1) : 0};
  scene.material = {.red = dice.between(0, 1),
                    .green = dice.between(0, 1),
                    .blue = dice.between(0, 1),
                    .scatter_mm = dice.one_in(2) ? dice.between(0.1, 5) : 0,
                    .glow = dice.one_in(2) ? dice.between(0, 1) : 0};
  scene.shadow = {.coefficient = dice.one_in(4) ? 1 : dice.between(0, 0.9),
                  .softness_mm = dice.one_in(2) ? dice.between(1, 40) : 0};
}

/// Any of the three lights on, also none.
void set_lamps(Dice& dice, Scene& scene) {
  scene.light.on = dice.any_to(LightSwitch::kOn);
  scene.light.strength = dice.between(0, 2);
  for (Scene::Lamp* lamp : {&scene.fill_light, &scene.back_light}) {
    *lamp = {.on = dice.any_to(LightSwitch::kOn),
             .right_mm = dice.between(-60, 60),
             .up_mm = dice.between(-60, 60),
             .depth_mm = dice.between(-50, 50),
             .red = dice.between(0, 1),
             .green = dice.between(0, 1),
             .blue = dice.between(0, 1),
             .strength = dice.between(0, 2)};
  }
}

void set_finish(Dice& dice, Scene::Finish& finish) {
  finish = {.smoothing = dice.any_to(Smoothing::kDiffusion),
            .iterations = dice.whole(1, 20),
            .conductance = dice.between(4, 40),
            .colours = dice.one_in(2) ? dice.any_to(ColourMap::kHeat) : ColourMap::kNone,
            .exposure = dice.between(0.3, 3),
            .tone = dice.any_to(Tone::kFilm)};
}

}  // namespace

SeededCase seeded_case(std::uint32_t seed) {
  constexpr PictureSize kSizes[] = {{61, 53}, {40, 64}, {33, 47}, {58, 37}};
  Dice dice(seed);
  SeededCase made;
  made.seed = seed;
  made.geometry = made_geometry(dice);
  made.angles_rad = made_angles(dice);
  made.size = kSizes[dice.whole(0, 3)];
  Body body = made_body(dice, made.geometry);

  Scene& scene = made.scene;
  const auto [first_rad, last_rad] = std::ranges::minmax(made.angles_rad);
  scene = scene_for(made.geometry, first_rad, last_rad);
  scene.mode = dice.one_in(3) ? Mode::kSurface : dice.any_to(Mode::kSlices);
  set_camera(dice, scene);
  const Point within{scene.camera.target.x_mm, body.depth_mm, scene.camera.target.z_mm};
  cut(dice, within, scene);
  set_slices(dice, within, scene);
  set_detector(dice, body, made.geometry.finest_mm(), scene);
  // The margin of a sector grows with the reach of pass 0; little would remain of such small frames.
  if (made.geometry.sector.half_angle_deg > 0) scene.speckle.size = std::min(scene.speckle.size, 3);
  set_filter(dice, scene.filter);
  set_light(dice, scene);
  set_finish(dice, scene.finish);

  made.grey = noisy(body, seed);
  body.depth_mm += dice.between(-1.5, 1.5);
  made.moved_grey = noisy(body, seed + 1'000'000);
  scene.detector.frame_steps = dice.any_to(FrameSteps::kRemoved);
  if (made.geometry.kind == FrameKind::kCartesian && made.geometry.sector.half_angle_deg == 0) {
    made.geometry.zero_is_unscanned = dice.one_in(2);
    if (made.geometry.zero_is_unscanned) {
      made.grey = within_wedge(dice, made.grey);
      made.moved_grey = within_wedge(dice, made.moved_grey);
    }
  }
  // Dice of their own, so that cases without cuts stay as they are.
  if (Dice scalpel(seed + 5'000'000); scalpel.one_in(3))
    scene.cuts.shapes = made_cuts(scalpel, within, scene);
  Dice far(seed + 6'000'000);
  scene.light.half_mm = far.one_in(3) ? far.between(2, 60) : 0;
  if (far.one_in(2)) scene.slice.slab_mm = far.between(0.5, 12);
  scene.slice.slab = far.any_to(Slab::kXRay);
  scene.light.haze = far.one_in(3) ? far.between(0.005, 0.1) : 0;
  Dice lamps(seed + 7'000'000);
  if (lamps.one_in(2)) set_lamps(lamps, scene);
  if (lamps.one_in(2)) scene.finish.outline = lamps.whole(1, 8);
  if (lamps.one_in(8)) scene.mode = Mode::kTomography;
  scene.slice.plane = lamps.any_to(SlicePlane::kView);
  scene.slice.step_mm = lamps.between(0.5, 8);
  if (Dice turn(seed + 9'000'000); turn.one_in(2)) {
    scene.slice.yaw_deg = turn.between(-180, 180);
    scene.slice.pitch_deg = turn.between(-80, 80);
    scene.slice.roll_deg = turn.between(-180, 180);
  }
  if (Dice glass(seed + 8'000'000); glass.one_in(4)) {
    scene.glass.amount = glass.between(0.1, 1);
    if (glass.one_in(2)) scene.mode = Mode::kSurface;
  }
  // Half of the bodies' contrast and less: what is shown is uncertain, or certain.
  scene.detector.least_contrast = dice.between(1, 25);
  return made;
}

}  // namespace fanlight::test
