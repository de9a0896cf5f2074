// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/auto_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "renderer/survey/echo_survey.hpp"
#include "renderer/survey/near_tissue_survey.hpp"
#include "renderer/survey/shell_survey.hpp"
#include "renderer/survey/surface_survey.hpp"

namespace fanlight {

namespace {

// Of the field: a round body extends beyond the part of it that the survey sees.
constexpr double kMargin = 1.45;
constexpr double kBodyMargin = 1.65;  // its outline is seen, against the dark
// Of clarity(). A liver's diaphragm, torn by shadows, has 0.24; sheets of the simulated probe, 0.3 to 0.5.
constexpr double kLeastSure = 0.27;
// Of the near wall of a shell, by the detector, where it looks for it first.
constexpr double kLeastFoundOfShell = 0.5;
constexpr double kLeastAtFan = 0.03;  // of the border
constexpr double kBehindMm = 12;      // rays continue behind the sheet
// Of the field, behind a body: half of a round one's width.
constexpr double kOutlineShare = 0.3;
constexpr double kBeforeWallMm = kSurveyWindowMm;  // else the detector sees it
constexpr double kNearestOfWall = 0.05;            // of its points: a share may be of something else

/// Quantiles of the points along a direction, mm from the centre.
struct Extent {
  double low = 0;
  double high = 0;
};
Extent extent_along(const SurfaceSurvey& survey, const glm::dvec3& direction, double share) {
  std::vector<double> places;
  for (const glm::dvec3& point : survey.points) places.push_back(glm::dot(point - survey.centre, direction));
  std::ranges::sort(places);
  const auto at = [&](double quantile) {
    return places[static_cast<std::size_t>(quantile * static_cast<double>(places.size() - 1))];
  };
  return {at(share), at(1 - share)};
}

/// How far the rays continue behind the farthest part of the sheet that is seen. Depths from the centre of
/// the sheet; `middle`: of the picture.
double reach_behind(const SurfaceSurvey& survey, const ViewFrame& frame, const glm::dvec3& middle,
                    double field_mm, double aspect, double far_mm) {
  if (!survey.is_body) return kBehindMm;
  // The outline of a round body lies behind the part of it that was found. Of the wall behind it no more is
  // shown than a plane cannot part from the body.
  double reach_mm = kOutlineShare * field_mm;
  std::vector<double> wall_mm;
  for (const glm::dvec3& point : survey.behind) {
    const glm::dvec3 aside = point - middle;
    if (std::abs(glm::dot(aside, frame.right)) > aspect * field_mm / 2) continue;
    if (std::abs(glm::dot(aside, frame.up)) > field_mm / 2) continue;
    wall_mm.push_back(glm::dot(point - survey.centre, frame.forward));
  }
  if (!wall_mm.empty()) {
    const auto nearest =
        wall_mm.begin() + static_cast<std::ptrdiff_t>(kNearestOfWall * static_cast<double>(wall_mm.size()));
    std::ranges::nth_element(wall_mm, nearest);
    reach_mm = std::min(reach_mm, *nearest - kBeforeWallMm - far_mm);
  }
  return std::max(kBehindMm, reach_mm);
}

/// Of an angle that is printed without a fraction: 0, not -0.
double without_sign_of_zero(double value) {
  return value == 0 ? 0 : value;
}

}  // namespace

std::optional<AutoScene> auto_scene(const Volume& volume, const Scene& scene, const PictureSize& size,
                                    const std::stop_token& stop) {
  // Rings of a probe in air are the smoothest sheet of all.
  if (volume.stamp().warnings.has(SweepWarning::kRings)) return std::nullopt;
  const EchoLevels levels = measured_levels(volume);
  const auto near_tissue = find_near_tissue(volume, levels);
  // A head that touches the tissue before it: its near side is looked for, not the far one from within.
  auto shell = near_tissue ? std::nullopt : find_shell(volume, stop);
  if (shell && shell->near_wall.found_share < kLeastFoundOfShell) shell.reset();
  const auto survey =
      shell ? std::optional(shell->near_wall) : find_surface(volume, levels, stop, near_tissue);
  if (!survey) return std::nullopt;
  AutoScene made{.scene = scene, .choices = {}};
  Scene& to = made.scene;
  const auto choose = [&](const std::string& sentence) { made.choices.push_back(sentence); };

  to.camera.yaw_deg = survey->yaw_deg;
  to.camera.pitch_deg = survey->pitch_deg;
  to.camera.roll_deg = 0;
  const ViewFrame frame = view_frame(to.camera);
  const Extent across = extent_along(*survey, frame.right, 0.01);
  const Extent upward = extent_along(*survey, frame.up, 0.01);
  const Extent along = extent_along(*survey, frame.forward, 0.02);
  const glm::dvec3 middle = survey->centre + frame.right * ((across.low + across.high) / 2) +
                            frame.up * ((upward.low + upward.high) / 2);
  const auto tenth = [](double value) { return std::round(10 * value) / 10; };
  to.camera.target = {tenth(middle.x), tenth(middle.y), tenth(middle.z)};
  const double aspect = static_cast<double>(size.width) / size.height;
  to.camera.field_mm = std::ceil((survey->is_body ? kBodyMargin : kMargin) *
                                 std::max(upward.high - upward.low, (across.high - across.low) / aspect));
  // The detector needs a whole window before the sheet.
  const double start_mm = survey->start_mm - glm::dot(survey->view, survey->centre) - kSurveyWindowMm;
  to.camera.distance_mm = tenth(std::max(0.0, -start_mm));
  to.rays.start_mm = tenth(std::max(0.0, start_mm));
  const double far_mm = std::max(along.high, start_mm);
  const double behind_mm = reach_behind(*survey, frame, middle, to.camera.field_mm, aspect, far_mm);
  to.rays.end_mm = tenth(to.camera.distance_mm + far_mm + behind_mm);
  choose(fmt::format("{} {:.0f} x {:.0f} mm", survey->is_body ? "a body in fluid," : "a sheet of",
                     across.high - across.low, upward.high - upward.low));
  if (near_tissue) choose("the tissue before the first fluid is removed");
  if (survey->at_fan_share >= kLeastAtFan)
    choose(fmt::format("the scanned fan ends at {:.0f} % of its border", 100 * survey->at_fan_share));
  choose(fmt::format(
      "it is in {:.0f} % of the beams; the echo steps {} by {:.0f} grey levels there, by {:.0f} elsewhere",
      100 * survey->covered_share, survey->sign == EdgeSign::kDarkToBright ? "up" : "down", survey->contrast,
      survey->clutter));
  choose(fmt::format("the camera looks at it at a right angle: yaw {:.0f}, pitch {:.0f} deg",
                     without_sign_of_zero(to.camera.yaw_deg), without_sign_of_zero(to.camera.pitch_deg)));
  const double before_mm = along.low - start_mm;
  choose(fmt::format("rays begin {:.0f} mm {} its nearest part and end {:.0f} mm behind its farthest",
                     std::abs(before_mm), before_mm >= 0 ? "before" : "behind", behind_mm));

  // The preset for bone, which shows its bright line.
  if (to.near.before_bone == NearTissueShow::kRemoved) to.detector.place = SurfacePlace::kLevel;
  to.near.tissue = near_tissue ? NearTissueShow::kRemoved : NearTissueShow::kShown;
  to.near.before_bone = shell ? NearTissueShow::kRemoved : NearTissueShow::kShown;
  if (shell) {
    to.detector.place = SurfacePlace::kRidge;
    choose(
        fmt::format("a closed bright shell of {:.0f} mm across, such as a skull: its near side is shown, and "
                    "what lies before it is removed",
                    2 * shell->radius_mm));
  }

  to.rays.step_mm = 0;
  to.detector.window_mm = 2 * kSurveyWindowMm;
  to.detector.threshold = survey->threshold;
  to.detector.sign = survey->sign;
  // The sheet is judged by its own step, not by the levels of the whole volume.
  to.detector.least_tissue = 1;
  choose(fmt::format(
      "the detector compares {:.0f} mm on either side and asks for {:.0f} grey levels; {:.0f} % of "
      "the surface are the first such step of their beams",
      kSurveyWindowMm, survey->threshold, 100 * survey->found_share));

  // Steep enough that the sheet's own relief throws short shadows.
  to.light.right_mm = tenth(-0.4 * to.camera.field_mm);
  to.light.up_mm = tenth(0.4 * to.camera.field_mm);
  to.light.depth_mm = tenth(-0.7 * to.camera.field_mm);
  place_fill_and_back_light(to);
  choose("the light comes from the upper left");
  made.is_sure = shell || survey->is_body || clarity(*survey) >= kLeastSure;
  if (!made.is_sure) choose("it is small or torn: slices beside it (mode slices) show more");
  limit(to);
  return made;
}

}  // namespace fanlight
