#include "proto/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <type_traits>

namespace fanlight {

namespace {

constexpr std::string_view kSigns[] = {"dark-to-bright", "bright-to-dark", "either"};
constexpr std::string_view kModes[] = {"surface", "volume"};
constexpr std::string_view kFinishes[] = {"none", "mean"};

using Choices = std::span<const std::string_view>;

// One accessor for both directions, so that a row names its member once.
template <auto kMember>
SceneField row(std::string_view name, std::string_view unit, std::string_view help, double minimum,
               double maximum, double step, FirstPass first_pass, Choices choices = {}) {
  return {.name = name,
          .unit = unit,
          .help = help,
          .minimum = minimum,
          .maximum = choices.empty() ? maximum : static_cast<double>(choices.size() - 1),
          .step = step,
          .first_pass = first_pass,
          .choices = choices,
          .get = [](const Scene& scene) { return static_cast<double>(kMember(const_cast<Scene&>(scene))); },
          .set =
              [](Scene& scene, double value) {
                auto& member = kMember(scene);
                member = static_cast<std::remove_reference_t<decltype(member)>>(value);
              }};
}

// NOLINTBEGIN(bugprone-macro-parentheses): a member path cannot stand in parentheses.
#define MEMBER(path)           \
  [](Scene & scene) -> auto& { \
    return scene.path;         \
  }
// NOLINTEND(bugprone-macro-parentheses)

const SceneField kFields[] = {
    row<MEMBER(camera.target.x_mm)>("camera.target_x_mm", "mm",
                                    "point that the orbit keeps in the middle, lateral", -1000, 1000, 0,
                                    FirstPass::kCast),
    row<MEMBER(camera.target.y_mm)>("camera.target_y_mm", "mm", "the same, below the probe face", -1000, 1000,
                                    0, FirstPass::kCast),
    row<MEMBER(camera.target.z_mm)>("camera.target_z_mm", "mm", "the same, elevation", -1000, 1000, 0,
                                    FirstPass::kCast),
    row<MEMBER(camera.yaw_deg)>("camera.yaw_deg", "deg",
                                "orbit about elevation, positive towards the marked side", -180, 180, 0,
                                FirstPass::kCast),
    row<MEMBER(camera.pitch_deg)>("camera.pitch_deg", "deg", "orbit upwards", -90, 90, 0, FirstPass::kCast),
    row<MEMBER(camera.roll_deg)>("camera.roll_deg", "deg",
                                 "turn of the camera about its view direction, clockwise", -180, 180, 0,
                                 FirstPass::kCast),
    row<MEMBER(camera.distance_mm)>("camera.distance_mm", "mm", "from the view plane to the target", 0, 2000,
                                    0, FirstPass::kCast),
    row<MEMBER(camera.field_mm)>("camera.field_mm", "mm", "height of the picture in the body", 1, 2000, 0,
                                 FirstPass::kCast),
    row<MEMBER(rays.start_mm)>("rays.start_mm", "mm", "depth below the view plane at which rays start", 0,
                               2000, 0, FirstPass::kCast),
    row<MEMBER(rays.end_mm)>("rays.end_mm", "mm", "depth at which they end", 0, 3000, 0, FirstPass::kCast),
    row<MEMBER(rays.step_mm)>("rays.step_mm", "mm",
                              "distance of samples; 0 takes the finer pixel size of the frame", 0, 10, 0,
                              FirstPass::kCast),
    row<MEMBER(detector.threshold)>("detector.threshold", "grey levels",
                                    "step in the echo that makes a surface", 0, 255, 0, FirstPass::kCast),
    row<MEMBER(detector.window)>("detector.window", "samples",
                                 "samples that the edge detector compares, even", 2, 32, 2, FirstPass::kCast),
    row<MEMBER(detector.sign)>("detector.sign", "", "which way the echo must step", 0, 0, 1, FirstPass::kCast,
                               kSigns),
    row<MEMBER(transfer.transparent)>("transfer.transparent", "grey levels",
                                      "volume mode: nothing is seen up to here", 0, 255, 0, FirstPass::kCast),
    row<MEMBER(transfer.opaque)>("transfer.opaque", "grey levels", "volume mode: full opacity from here", 0,
                                 255, 0, FirstPass::kCast),
    row<MEMBER(transfer.opacity_per_mm)>("transfer.opacity_per_mm", "per mm",
                                         "volume mode: share of light stopped by a millimetre", 0, 0.999, 0,
                                         FirstPass::kCast),
    row<MEMBER(filter.size)>("filter.size", "pixels", "side of the moving average over the depth map, odd", 1,
                             31, 2, FirstPass::kLight),
    row<MEMBER(light.right_mm)>("light.right_mm", "mm", "point light, right of the picture's centre", -2000,
                                2000, 0, FirstPass::kLight),
    row<MEMBER(light.up_mm)>("light.up_mm", "mm", "point light, above the picture's centre", -2000, 2000, 0,
                             FirstPass::kLight),
    row<MEMBER(light.depth_mm)>("light.depth_mm", "mm",
                                "point light, beyond the view plane (negative: before it)", -2000, 2000, 0,
                                FirstPass::kLight),
    row<MEMBER(light.ambient)>("light.ambient", "", "light from everywhere", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(light.diffuse)>("light.diffuse", "", "matt reflection", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(light.specular)>("light.specular", "", "shiny reflection", 0, 1, 0, FirstPass::kLight),
    row<MEMBER(light.shininess)>("light.shininess", "", "exponent of the shiny reflection", 1, 256, 0,
                                 FirstPass::kLight),
    row<MEMBER(shadow.coefficient)>("shadow.coefficient", "", "brightness left in a shadow; 1 casts none", 0,
                                    1, 0, FirstPass::kLight),
    // Surface mode ends each ray at the surface, so that the volume's colours are only there when asked for.
    row<MEMBER(mode)>("mode", "", "what the picture shows", 0, 0, 1, FirstPass::kCast, kModes),
    row<MEMBER(finish)>("finish", "", "smoothing of the picture: none, or a 2 x 2 mean", 0, 0, 1,
                        FirstPass::kLight, kFinishes),
};

#undef MEMBER

std::string allowed(const SceneField& field) {
  if (!field.choices.empty()) return fmt::format("one of {}", fmt::join(field.choices, ", "));
  const std::string unit = field.unit.empty() ? "" : fmt::format(" {}", field.unit);
  const std::string step =
      field.step == 0 ? "" : fmt::format(" in steps of {} from {}", field.step, field.minimum);
  return fmt::format("a number from {} to {}{}{}", field.minimum, field.maximum, unit, step);
}

Error refusal(const SceneField& field, std::string_view given) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{} is {}, expected {}", field.name, given, allowed(field))};
}

}  // namespace

std::span<const SceneField> scene_fields() {
  return kFields;
}

const SceneField* find_scene_field(std::string_view name) {
  const auto* found = std::ranges::find(kFields, name, &SceneField::name);
  return found == std::end(kFields) ? nullptr : found;
}

Result<void> set_field(Scene& scene, const SceneField& field, double value) {
  const bool in_range = value >= field.minimum && value <= field.maximum;  // false for a NaN
  const bool on_step = field.step == 0 || std::fmod(value - field.minimum, field.step) == 0;
  if (!in_range || !on_step) return refusal(field, fmt::format("{}", value));
  field.set(scene, value);
  return {};
}

Result<void> set_field(Scene& scene, const SceneField& field, std::string_view text) {
  if (!field.choices.empty()) {
    const auto found = std::ranges::find(field.choices, text);
    if (found == field.choices.end()) return refusal(field, fmt::format("\"{}\"", text));
    field.set(scene, static_cast<double>(found - field.choices.begin()));
    return {};
  }
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || end != text.data() + text.size()) {
    return refusal(field, fmt::format("\"{}\"", text));
  }
  return set_field(scene, field, value);
}

Result<void> check(const Scene& scene) {
  if (scene.rays.start_mm >= scene.rays.end_mm) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("rays.start_mm is {} and rays.end_mm is {}, expected the start before the end",
                             scene.rays.start_mm, scene.rays.end_mm)};
  }
  if (scene.rays.step_mm > 0 &&
      scene.rays.step_mm * kMostSamplesOnARay < scene.rays.end_mm - scene.rays.start_mm) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("rays.step_mm is {}, expected 0 or at most {} samples between start and end",
                             scene.rays.step_mm, kMostSamplesOnARay)};
  }
  if (scene.transfer.transparent >= scene.transfer.opaque) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("transfer.transparent is {} and transfer.opaque is {}, expected a rising ramp",
                             scene.transfer.transparent, scene.transfer.opaque)};
  }
  return {};
}

FirstPass first_pass_changed(const Scene& from, const Scene& to) {
  auto first = FirstPass::kNone;
  for (const SceneField& field : kFields) {
    if (field.get(from) != field.get(to)) first = std::min(first, field.first_pass);
  }
  return first;
}

Scene relit(const Scene& cast, const Scene& newest) {
  Scene scene = cast;
  for (const SceneField& field : kFields) {
    if (field.first_pass == FirstPass::kLight) field.set(scene, field.get(newest));
  }
  return scene;
}

Scene scene_for(const FanGeometry& geometry, double first_angle_rad, double last_angle_rad) {
  const double depth_mm = geometry.depth_mm();
  const double middle_rad = (first_angle_rad + last_angle_rad) / 2;
  const double swept_rad = std::abs(last_angle_rad - first_angle_rad);
  const double width_mm = geometry.right_mm() - geometry.left_mm();
  const double height_mm =
      2 * (geometry.motor_radius_mm + depth_mm / 2) * std::sin(std::min(swept_rad, kPi) / 2);

  Scene scene;
  scene.camera.target = geometry.point((geometry.left_mm() + geometry.right_mm()) / 2,
                                       {.angle_rad = middle_rad, .depth_mm = depth_mm / 2});
  scene.camera.pitch_deg = degrees(-middle_rad);
  scene.camera.distance_mm = depth_mm / 2;
  scene.camera.field_mm = std::max(width_mm, height_mm);
  scene.rays.end_mm = depth_mm;
  scene.light.right_mm = -0.42 * scene.camera.field_mm;
  scene.light.up_mm = 0.42 * scene.camera.field_mm;
  scene.light.depth_mm = -0.4 * scene.camera.field_mm;
  // A fan may be larger than any picture of it may be.
  for (const SceneField& field : kFields) {
    field.set(scene, std::clamp(field.get(scene), field.minimum, field.maximum));
  }
  return scene;
}

}  // namespace fanlight
