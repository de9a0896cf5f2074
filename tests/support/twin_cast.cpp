// SPDX-License-Identifier: Apache-2.0
// CPU twin of pass 1 (shaders/cast.comp, confidence.comp, slice.comp; renderer/ALGORITHM.md, pass 1): whole
// rays in double precision, without batches, running sums, or empty space skipping.
#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <optional>

#include "tests/support/cpu_twin.hpp"
#include "tests/support/twin_cuts.hpp"
#include "tests/support/twin_echo.hpp"
#include "tests/support/twin_edges.hpp"
#include "tests/support/twin_layers.hpp"
#include "tests/support/twin_place.hpp"
#include "tests/support/twin_ray.hpp"

namespace fanlight::test {

namespace {

using glm::dvec3;

/// Samples along a ray, 0 to 1; nullopt: not scanned.
using SampleValues = std::vector<std::optional<double>>;

/// The samples of one ray. With a window, each is the mean of rings of three points across it
/// (shaders/ray.h).
class RaySamples {
 public:
  RaySamples(const Scene& scene, const Volume& prepared, const Ray& ray)
      : scene_(scene), prepared_(prepared), ray_(ray), step_mm_(step_of(scene, prepared.geometry())) {
    const dvec3 along = glm::normalize(ray.direction);
    const dvec3 right = view_frame(scene.camera).right;
    right_ = glm::normalize(right - glm::dot(right, along) * along);
    up_ = glm::cross(right_, along);
    depth_step_mm_ = step_mm_ / glm::length(ray.direction);
  }

  double depth_step_mm() const { return depth_step_mm_; }
  double end_mm() const { return scene_.rays.end_mm; }
  double depth_mm(double index) const { return scene_.rays.start_mm + index * depth_step_mm_; }

  /// The sample at a depth, 0 to 1; nullopt where nothing was scanned.
  std::optional<double> at(double depth_mm) const {
    if (depth_mm < ray_.eye_mm) return std::nullopt;
    const int window = scene_.rays.window;
    const dvec3 middle = ray_.at(depth_mm);
    if (window == 1) return twin_echo(scene_.speckle, prepared_, middle);
    std::vector<double> scanned;
    for (int point = 0; point < window / 2 * 3; ++point) {
      const double disc_mm = std::sqrt((window * window - 1) / 3.0) * step_mm_;
      const double angle = radians(120.0 * point + 60.0 * (point / 3 % 2));
      const dvec3 way = std::sin(angle) * right_ + std::cos(angle) * up_;
      const dvec3 beside = disc_mm * std::sqrt((2 * (point / 3) + 1.0) / (window - 1)) * way;
      const auto value = twin_echo(scene_.speckle, prepared_, middle + beside);
      if (value) scanned.push_back(*value);
    }
    if (scanned.empty() || !is_within_frames(scene_.speckle, prepared_, middle)) return std::nullopt;
    return std::accumulate(scanned.begin(), scanned.end(), 0.0) / static_cast<double>(scanned.size());
  }

  /// All samples from the start of the ray to its end.
  SampleValues all() const {
    SampleValues values;
    for (int index = 0; depth_mm(index) <= scene_.rays.end_mm; ++index) values.push_back(at(depth_mm(index)));
    return values;
  }

 private:
  const Scene& scene_;
  const Volume& prepared_;
  Ray ray_;
  double step_mm_;
  double depth_step_mm_ = 0;
  dvec3 right_{};
  dvec3 up_{};
};

/// The position where the threshold is crossed, in windows: interpolated between the first window that
/// exceeds it and the previous one.
double first_crossing(const std::vector<double>& heights, std::size_t first, double threshold) {
  const double position = static_cast<double>(first);
  if (first == 0 || heights[first] <= heights[first - 1]) return position;
  return position -
         std::clamp((heights[first] - threshold) / (heights[first] - heights[first - 1]), 0.0, 1.0);
}

/// The first peak, interpolated, of which no later one has this share; -1 without one (`placed` in
/// surface_place.h).
double front_peak(const std::vector<double>& values, double share) {
  double found = -1;
  double highest = 1e-6;
  for (std::size_t at = 0; at < values.size(); ++at) {
    const double before = at > 0 ? values[at - 1] : -1;
    const double after = at + 1 < values.size() ? values[at + 1] : -1;
    constexpr double kAlike = 1.001;
    const double reach = kAlike * values[at];
    if (share * values[at] <= highest || reach < before || reach < after) continue;
    const double curvature = before - 2 * values[at] + after;
    const bool known = before >= 0 && after >= 0 && curvature < 0;
    found = static_cast<double>(at) + (known ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0);
    highest = values[at];
  }
  return found;
}

/// Where in the window about `position`, in samples of the run, the surface lies (surface_place.h).
double placed(const Scene::Detector& detector, const std::vector<double>& run, double position) {
  const auto window = static_cast<std::size_t>(detector.window);
  const auto newest = std::min(
      run.size() - 1, static_cast<std::size_t>(std::ceil(position + static_cast<double>(window / 2) - 1)));
  const std::size_t oldest = newest + 1 - window;
  const std::vector<double> values(run.begin() + static_cast<std::ptrdiff_t>(oldest),
                                   run.begin() + static_cast<std::ptrdiff_t>(newest + 1));
  if (detector.place == SurfacePlace::kRidge) {
    const double ridge = front_peak(values, 1 / 1.001);
    return ridge < 0 ? position : static_cast<double>(oldest) + ridge;
  }
  const std::size_t narrow = window >= 4 ? 2 : 1;
  std::vector<double> steps(window, -1.0);
  for (std::size_t at = narrow; at + narrow <= window; ++at) {
    double sum = 0;
    for (std::size_t each = 0; each < narrow; ++each) sum += values[at + each] - values[at - 1 - each];
    steps[at] = detector.sign == EdgeSign::kEither         ? std::abs(sum)
                : detector.sign == EdgeSign::kDarkToBright ? sum
                                                           : -sum;
  }
  const double front = front_peak(steps, 0.4);
  return front < 0 ? position : static_cast<double>(oldest) + front - 0.5;
}

SampleEcho echo_of(const RaySamples& samples) {
  return [&samples](int index) {
    const double depth_mm = samples.depth_mm(index);
    return index >= 0 && depth_mm <= samples.end_mm() ? samples.at(depth_mm).value_or(0) : 0;
  };
}

/// The positions of all edges in a run of scanned samples, in samples from its first.
std::vector<double> edge_positions(const Scene::Detector& detector, const std::vector<double>& run) {
  const double threshold = detector.threshold / 255;
  const auto heights = window_heights(detector, run);
  std::vector<double> positions;
  for (std::size_t at = 0; at < heights.size(); ++at) {
    const bool crosses = heights[at] > threshold && (at == 0 || heights[at - 1] <= threshold);
    if (!crosses) continue;
    const double window = detector.place == SurfacePlace::kFirstCrossing
                              ? first_crossing(heights, at, threshold)
                              : steepest_window(heights, at, threshold).position;
    positions.push_back(window + 0.5 * (detector.window - 1));  // middle_of_window() in edge_detector.h
  }
  return positions;
}

struct FirstSurface {
  double depth_mm = kNoSurface;
  double edge = 0;  // its position, in samples from the ray's first
  double certainty = -1;
};

/// Whether a depth of a ray is cut away.
using IsCut = std::function<bool(double depth_mm)>;

/// The first surface that is neither cropped nor cut away.
FirstSurface first_surface(const Scene::Detector& detector, const RaySamples& samples, SampleValues values,
                           const DepthInterval& shown, const IsCut& is_cut) {
  values.emplace_back();  // nullopt: ends the last run
  std::vector<double> run;
  for (std::size_t index = 0; index < values.size(); ++index) {
    if (values[index]) {
      run.push_back(*values[index]);
      continue;
    }
    for (const double position : edge_positions(detector, run)) {
      const double first = static_cast<double>(index - run.size());
      if (!shown.holds(samples.depth_mm(first + position))) continue;
      const bool at_edge =
          detector.place == SurfacePlace::kFirstCrossing || detector.place == SurfacePlace::kRefined;
      std::optional<TwinPlace> place;
      if (detector.place == SurfacePlace::kLevel) {
        place = twin_place_by_level(detector, echo_of(samples), samples.depth_step_mm(), first + position);
      } else if (const auto certainty = twin_certainty(detector, echo_of(samples), first + position)) {
        place = TwinPlace{first + (at_edge ? position : placed(detector, run, position)), *certainty};
      }
      if (!place) continue;
      const double depth_mm = std::clamp(samples.depth_mm(place->position), shown.first_mm, shown.last_mm);
      if (is_cut(depth_mm)) continue;
      return {.depth_mm = depth_mm, .edge = first + position, .certainty = place->certainty};
    }
    run.clear();
  }
  return {};
}

struct Side {
  int count = 0;
  double mean = 0;
  double variance = 0;
};

/// Statistics of half a window before (direction -1) or behind (+1) a depth.
Side side_of(const Scene::Detector& detector, const RaySamples& samples, double depth_mm, int direction) {
  Side side;
  double squares = 0;
  for (int index = 0; index < detector.window / 2; ++index) {
    const auto value = samples.at(depth_mm + direction * (index + 0.5) * samples.depth_step_mm());
    if (!value) continue;
    ++side.count;
    side.mean += *value;
    squares += *value * *value;
  }
  if (side.count == 0) return side;
  side.mean /= side.count;
  side.variance = std::max(0.0, squares / side.count - side.mean * side.mean);
  return side;
}

/// The contrast of the edge over the noise on its two sides (confidence.comp).
double confidence_at(const Scene::Detector& detector, const RaySamples& samples, double depth_mm) {
  const Side near = side_of(detector, samples, depth_mm, -1);
  const Side far = side_of(detector, samples, depth_mm, 1);
  if (near.count == 0 || far.count == 0) return 0;
  return std::abs(far.mean - near.mean) / std::max(std::sqrt((near.variance + far.variance) / 2), 1 / 255.0);
}

/// Front-to-back compositing, with colour c and opacity a of a sample: C += (1 - A) a c, A += (1 - A) a.
Rgb composited(const TransferFunction& transfer, const std::vector<double>& values, double step_mm) {
  Rgb colour(0);
  double opacity = 0;
  for (const double value : values) {
    const TransferFunction::Value tissue = transfer.at(255 * value);
    const double share = 1 - std::pow(1 - tissue.opacity_per_mm, step_mm);
    colour += (1 - opacity) * share * Rgb(tissue.colour[0], tissue.colour[1], tissue.colour[2]);
    opacity += (1 - opacity) * share;
  }
  return colour;
}

/// The result of the ray besides the surface (ray_accumulator.h), by the mode.
Rgb accumulated_colour(const Scene& scene, const RaySamples& samples, const SampleValues& all,
                       const DepthInterval& shown, const IsCut& is_cut, double step_mm) {
  std::vector<double> values;
  double sum = 0;
  for (std::size_t index = 0; index < all.size(); ++index) {
    const double depth_mm = samples.depth_mm(static_cast<double>(index));
    if (!all[index] || !shown.holds(depth_mm) || is_cut(depth_mm)) continue;
    values.push_back(*all[index]);
    sum += *all[index];
  }
  if (values.empty()) return Rgb(0);
  switch (scene.mode) {
    case Mode::kVolume:
    case Mode::kSurfaceAndVolume:
      return composited(scene.transfer, values, step_mm);
    case Mode::kMaximum:
      return Rgb(std::ranges::max(values));
    case Mode::kMinimum:
      return Rgb(std::ranges::min(values));
    case Mode::kMean:
      return Rgb(sum / static_cast<double>(values.size()));
    default:
      return Rgb(0);
  }
}

/// The echo of the slab about a point of a plane; nullopt where nothing of it is shown (slice.comp).
std::optional<double> slab_echo(const Scene& scene, const Volume& prepared, const dvec3& at,
                                const dvec3& normal) {
  const Scene::Slice& slice = scene.slice;
  const double half_mm = slice.slab_mm / 2;
  const int to_a_side =
      half_mm > 0
          ? static_cast<int>(std::clamp(std::ceil(half_mm / step_of(scene, prepared.geometry())), 1.0, 32.0))
          : 0;
  const double step_mm = to_a_side > 0 ? half_mm / to_a_side : 0;
  std::vector<double> values;
  double sum = 0;
  for (int sample = -to_a_side; sample <= to_a_side; ++sample) {
    const dvec3 there = at + sample * step_mm * normal;
    if (!cropped(scene, {.origin = there, .direction = dvec3(0)}).holds(0)) continue;
    const auto echo = twin_echo(scene.speckle, prepared, there);
    if (!echo) continue;
    values.push_back(*echo);
    sum += *echo;
  }
  if (values.empty()) return std::nullopt;
  if (to_a_side == 0 || slice.slab == Slab::kMaximum) return std::ranges::max(values);
  if (slice.slab == Slab::kMean) return sum / static_cast<double>(values.size());
  return 1 - std::exp(-sum * step_mm / 10);
}

/// The echo at one point of a slice as grey; black where nothing was scanned or it is cropped, and dim where
/// it is cut away, with a line where that ends (slice.comp).
Rgb slice_colour(const Scene& scene, const Volume& prepared, const TwinCuts& cuts, const dvec3& at,
                 double pixel_mm, const dvec3& normal) {
  const auto echo = slab_echo(scene, prepared, at, normal);
  if (!echo) return Rgb(0);
  const Rgb grey(*echo);
  const double share = cuts.share(at);
  const double beyond_mm = std::abs(share - 0.5) * cuts.cell_mm();
  const double line =
      std::clamp(1.4 - beyond_mm / pixel_mm, 0.0, 1.0) * std::clamp(4 - 8 * std::abs(share - 0.5), 0.0, 1.0);
  return glm::mix(share >= 0.5 ? 0.3 * grey : grey, Rgb(0.35, 0.8, 1), line);
}

/// Mode::kSlice: a plane parallel to the picture, with the projection of the rays.
void cast_slice(const Scene& scene, PictureSize size, const Volume& prepared, TwinCast& cast) {
  const TwinCuts cuts(scene, prepared);
  const bool perspective = scene.camera.projection == Projection::kPerspective;
  const double scale =
      perspective ? (scene.slice.depth_mm + eye_height_mm(scene.camera)) / eye_distance_mm(scene.camera) : 1;
  const double pixel_mm = scene.camera.field_mm / size.height;
  for (std::uint32_t row = 0; row < size.height; ++row) {
    for (std::uint32_t column = 0; column < size.width; ++column) {
      const Ray ray = ray_through(scene.camera, (column - 0.5 * (size.width - 1.0)) * pixel_mm,
                                  (0.5 * (size.height - 1.0) - row) * pixel_mm);
      if (scene.slice.depth_mm < ray.eye_mm) continue;
      cast.colour[std::size_t{row} * size.width + column] =
          slice_colour(scene, prepared, cuts, ray.at(scene.slice.depth_mm), scale * pixel_mm,
                       view_frame(scene.camera).forward);
    }
  }
}

/// A direction of the planes A, B and C, turned: first about y by the roll, then about x by the pitch, then
/// about z by the yaw.
dvec3 turned(const Scene::Slice& slice, const dvec3& way) {
  const auto rotated = [](double degrees, double& from, double& to) {
    const double rad = radians(degrees);
    const double kept = from;
    from = std::cos(rad) * kept - std::sin(rad) * to;
    to = std::sin(rad) * kept + std::cos(rad) * to;
  };
  dvec3 at = way;
  rotated(-slice.roll_deg, at.x, at.z);   // clockwise: the right side dips
  rotated(-slice.pitch_deg, at.y, at.z);  // upwards: forward dips
  rotated(slice.yaw_deg, at.x, at.y);
  return at;
}

/// Mode::kSlices: three planes through the target, each in its part of the picture, with the target in the
/// middle.
void cast_slices(const Scene& scene, PictureSize size, const Volume& prepared, TwinCast& cast) {
  const TwinCuts cuts(scene, prepared);
  const std::uint32_t middle_column = size.width / 2;
  const std::uint32_t middle_row = size.height / 2;
  const Point& target = scene.camera.target;
  for (std::uint32_t row = 0; row < size.height; ++row) {
    for (std::uint32_t column = 0; column < size.width; ++column) {
      const bool left = column < middle_column;
      const bool upper = row < middle_row;
      if (!left && !upper) continue;  // the surface's part
      const std::uint32_t first_column = left ? 0 : middle_column;
      const std::uint32_t first_row = upper ? 0 : middle_row;
      const std::uint32_t width = left ? middle_column : size.width - middle_column;
      const std::uint32_t height = upper ? middle_row : size.height - middle_row;
      const double pixel_mm = scene.camera.field_mm / height;
      const double right_mm = (column - first_column - 0.5 * (width - 1.0)) * pixel_mm;
      const double down_mm = (row - first_row - 0.5 * (height - 1.0)) * pixel_mm;
      const dvec3 across = turned(scene.slice, left ? dvec3(1, 0, 0) : dvec3(0, 0, 1));
      const dvec3 down = turned(scene.slice, upper ? dvec3(0, 1, 0) : dvec3(0, 0, -1));
      const dvec3 at = dvec3(target.x_mm, target.y_mm, target.z_mm) + right_mm * across + down_mm * down;
      cast.colour[std::size_t{row} * size.width + column] =
          slice_colour(scene, prepared, cuts, at, pixel_mm, glm::cross(across, down));
    }
  }
}

/// Mode::kTomography: planes at equal distances, three in a row, each with the target's foot in its middle.
void cast_tomography(const Scene& scene, PictureSize size, const Volume& prepared, TwinCast& cast) {
  const TwinCuts cuts(scene, prepared);
  const auto view = view_frame(scene.camera);
  const Point& target = scene.camera.target;
  for (std::uint32_t row = 0; row < size.height; ++row) {
    for (std::uint32_t column = 0; column < size.width; ++column) {
      std::uint32_t across = 0;
      std::uint32_t below = 0;
      while (column >= (across + 1) * size.width / 3) ++across;
      while (row >= (below + 1) * size.height / 3) ++below;
      const double left = across * size.width / 3;  // whole numbers
      const double top = below * size.height / 3;
      const double width = (across + 1) * size.width / 3 - left;
      const double height = (below + 1) * size.height / 3 - top;
      const double pixel_mm = scene.camera.field_mm / height;
      dvec3 right(1, 0, 0);
      dvec3 down(0, 1, 0);
      if (scene.slice.plane == SlicePlane::kB) right = {0, 0, 1};
      if (scene.slice.plane == SlicePlane::kC) down = {0, 0, -1};
      right = turned(scene.slice, right);
      down = turned(scene.slice, down);
      if (scene.slice.plane == SlicePlane::kView) right = view.right;
      if (scene.slice.plane == SlicePlane::kView) down = -view.up;
      // To higher coordinates, or away from the viewer.
      const dvec3 away =
          scene.slice.plane == SlicePlane::kB ? glm::cross(down, right) : glm::cross(right, down);
      const double offset_mm = (3.0 * below + across - 4) * scene.slice.step_mm;
      const dvec3 at = dvec3(target.x_mm, target.y_mm, target.z_mm) + offset_mm * away +
                       (column - left - (width - 1) / 2) * pixel_mm * right +
                       (row - top - (height - 1) / 2) * pixel_mm * down;
      cast.colour[std::size_t{row} * size.width + column] =
          slice_colour(scene, prepared, cuts, at, pixel_mm, away);
    }
  }
}

/// Pass 1: the share of its certainty that a surface keeps where the ray runs against the beam
/// (`seen_by_beam` in shaders/cast.comp).
double seen_by_beam(const FanGeometry& geometry, const dvec3& at, const dvec3& direction) {
  if (geometry.unknown_beams) return 1;
  const bool has_apex = geometry.polar() || geometry.sector.half_angle_deg > 0;
  const dvec3 from_axis(0, at.y + geometry.motor_radius_mm, at.z);
  const double apex_mm = glm::length(from_axis) - geometry.motor_radius_mm + geometry.probe_radius_mm;
  const double across = has_apex ? at.x / apex_mm : 0;
  const dvec3 beam = glm::normalize(dvec3(across, 0, 0) + glm::normalize(from_axis));
  const double along = glm::dot(beam, glm::normalize(direction));
  return std::clamp((along + 0.866) / (0.866 - 0.5), 0.0, 1.0);  // from 120 to 150 degrees
}

Ray ray_of_pixel(const Scene& scene, const Viewport& part, std::uint32_t column, std::uint32_t row) {
  return ray_through(scene.camera, (column - part.centre_column()) * part.pixel_mm,
                     (part.centre_row() - row) * part.pixel_mm);
}

void cast_rays(const Scene& scene, PictureSize size, const Volume& prepared, TwinCast& cast) {
  const TwinCuts cuts(scene, prepared);
  const Viewport part = viewport(scene, size);
  for (std::uint32_t row = part.top; row < part.top + part.height; ++row) {
    for (std::uint32_t column = part.left; column < part.left + part.width; ++column) {
      const std::size_t pixel = std::size_t{row} * size.width + column;
      const Ray ray = ray_of_pixel(scene, part, column, row);
      const RaySamples samples(scene, prepared, ray);
      const DepthInterval shown = cropped(scene, ray);
      const SampleValues values = samples.all();
      const IsCut is_cut = [&](double depth_mm) { return cuts.is_cut(ray.at(depth_mm)); };
      const FirstSurface surface = first_surface(scene.detector, samples, values, shown, is_cut);
      cast.depth_mm[pixel] = surface.depth_mm;
      const double seen = surface.depth_mm >= 0
                              ? seen_by_beam(prepared.geometry(), ray.at(surface.depth_mm), ray.direction)
                              : 1;
      cast.certainty[pixel] = seen * surface.certainty;
      cast.colour[pixel] =
          accumulated_colour(scene, samples, values, shown, is_cut, step_of(scene, prepared.geometry()));
      if (!is_glass(scene) || surface.depth_mm < 0) continue;
      const LayeredRay layered{.scene = scene,
                               .prepared = prepared,
                               .ray = ray,
                               .values = values,
                               .depth_step_mm = samples.depth_step_mm(),
                               .surface_edge = surface.edge};
      cast.colour[pixel] =
          twin_layers(layered, [&](double depth_mm) { return shown.holds(depth_mm) && !is_cut(depth_mm); });
    }
  }
}

/// Takes the mean across the frames, and computes the confidence of the surfaces that the rays found.
void finish_surfaces(const Scene& scene, PictureSize size, const Volume& prepared, TwinCast& cast) {
  const std::vector<double> ray_mm = cast.depth_mm;
  const bool shows_depths = scene.mode == Mode::kSurface || scene.mode == Mode::kSurfaceAndVolume ||
                            scene.mode == Mode::kDepth || scene.mode == Mode::kSlices;
  if (scene.detector.frame_steps == FrameSteps::kRemoved && shows_depths)
    cast.depth_mm = twin_frame_steps(scene, size, prepared, ray_mm);
  const Viewport part = viewport(scene, size);
  for (std::uint32_t row = part.top; row < part.top + part.height; ++row) {
    for (std::uint32_t column = part.left; column < part.left + part.width; ++column) {
      const std::size_t pixel = std::size_t{row} * size.width + column;
      double& depth_mm = cast.depth_mm[pixel];
      if (depth_mm < 0) continue;
      const Ray ray = ray_of_pixel(scene, part, column, row);
      const DepthInterval shown = cropped(scene, ray);
      if (depth_mm != ray_mm[pixel]) {
        depth_mm = std::clamp(depth_mm, std::max(shown.first_mm, scene.rays.start_mm),
                              std::min(shown.last_mm, scene.rays.end_mm));
      }
      cast.confidence[pixel] = confidence_at(scene.detector, RaySamples(scene, prepared, ray), ray_mm[pixel]);
    }
  }
}

}  // namespace

TwinCast twin_cast(const Scene& scene, PictureSize size, const Volume& prepared) {
  const std::size_t pixels = std::size_t{size.width} * size.height;
  TwinCast cast{.depth_mm = std::vector(pixels, kNoSurface),
                .confidence = std::vector(pixels, 0.0),
                .certainty = std::vector(pixels, -1.0),
                .colour = std::vector(pixels, Rgb(0))};
  if (scene.mode == Mode::kSlice) cast_slice(scene, size, prepared, cast);
  if (scene.mode == Mode::kSlices) cast_slices(scene, size, prepared, cast);
  if (scene.mode == Mode::kTomography) cast_tomography(scene, size, prepared, cast);
  if (scene.mode == Mode::kSlice || scene.mode == Mode::kTomography) return cast;
  cast_rays(scene, size, prepared, cast);
  finish_surfaces(scene, size, prepared, cast);
  return cast;
}

}  // namespace fanlight::test
