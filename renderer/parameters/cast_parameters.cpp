// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/cast_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "renderer/parameters/light_parameters.hpp"
#include "renderer/parameters/speckle_filter.hpp"
#include "renderer/parameters/window_across.hpp"
#include "shaders/bindings.h"
#include "shaders/prepare_constants.h"

namespace fanlight {

namespace {

// Farther than any point in the body.
constexpr double kFarMm = 1e4;

/// The largest depth below the view plane in the box.
double farthest_depth_mm(const Box& box, const ViewFrame& view) {
  double farthest_mm = -HUGE_VAL;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at((corner & 1) != 0 ? box.highest.x : box.lowest.x,
                        (corner & 2) != 0 ? box.highest.y : box.lowest.y,
                        (corner & 4) != 0 ? box.highest.z : box.lowest.z);
    farthest_mm = std::max(farthest_mm, glm::dot(at - view.centre, view.forward));
  }
  return farthest_mm;
}

/// The ray of pixel (column, row) starts at a point in the view plane. Its origin and its direction are
/// linear in column and row.
void set_rays(shaders::CastParameters& to, const Scene& scene, PictureSize size) {
  const ViewFrame view = view_frame(scene.camera);
  const Viewport port = viewport(scene, size);
  const double eye_mm = eye_distance_mm(scene.camera);
  const glm::dvec3 right_step = port.pixel_mm * view.right;
  const glm::dvec3 down_step = -port.pixel_mm * view.up;
  // From the centre of the viewport to pixel (0, 0).
  const glm::dvec3 corner = -port.centre_column() * right_step - port.centre_row() * down_step;
  const double turn = is_perspective(scene.camera) ? 1 / eye_mm : 0;
  const double shrink = is_perspective(scene.camera) ? eye_height_mm(scene.camera) / eye_mm : 1;
  to.origin = view.centre + shrink * corner;
  to.right_step = shrink * right_step;
  to.down_step = shrink * down_step;
  to.forward = view.forward + turn * corner;
  to.right_turn = turn * right_step;
  to.down_turn = turn * down_step;
  to.right = view.right;
  to.width = size.width;
  to.height = size.height;
  to.view_left = port.left;
  to.view_top = port.top;
  to.view_width = port.width;
  to.view_height = port.height;
  to.pixel_stride = static_cast<std::uint32_t>(scene.rays.stride);
}

void set_samples(shaders::CastParameters& to, const Scene& scene, double finest_mm, double farthest_mm) {
  const Scene::Rays& rays = scene.rays;
  const double end_mm = std::min(rays.end_mm, farthest_mm);
  const double step_mm = rays.step_mm > 0
                             ? rays.step_mm
                             : std::max(finest_mm, (end_mm - rays.start_mm) / (kMostSamplesOnARay - 1));
  // Length of the longest ray, to a corner of the picture, per mm of depth: below 2.7 in a square picture of
  // 120 deg.
  constexpr double kWidestRay = 4;
  const double widest = glm::length(glm::dvec3(to.forward));
  const double samples = std::max(0.0, (end_mm - rays.start_mm) * widest / step_mm + 1);
  to.start = static_cast<float>(rays.start_mm);
  to.end = static_cast<float>(end_mm);
  to.eye = static_cast<float>(is_perspective(scene.camera) ? -eye_height_mm(scene.camera) : -kFarMm);
  to.step = static_cast<float>(step_mm);
  to.steps = static_cast<std::uint32_t>(std::min(samples, kWidestRay * kMostSamplesOnARay));
}

void set_frames(shaders::CastParameters& to, const FanGeometry& geometry, const AngleTable& table,
                const VolumeExtent& volume) {
  to.angle_scale = static_cast<float>(table.scale());
  to.angle_offset = static_cast<float>(table.offset());
  to.last_angle_entry = static_cast<float>(table.entries().size() - 1);
  const double column = geometry.polar() ? radians(geometry.line_pitch_deg) : geometry.pixel_width_mm;
  to.column_scale = static_cast<float>(1 / column);
  to.column_offset = static_cast<float>(geometry.face_column);
  to.row_scale = static_cast<float>(1 / geometry.pixel_height_mm);
  to.row_offset = static_cast<float>(geometry.face_row);
  to.last_column = static_cast<float>(geometry.columns - 1);
  to.last_row = static_cast<float>(geometry.rows - 1);
  to.last_frame = static_cast<float>(volume.frames - 1);
  to.voxel_scale = 1.0F / glm::vec3(geometry.columns, geometry.rows, volume.frame_capacity);
  to.packed_stride = static_cast<int>(FANLIGHT_PACKED_STRIDE(geometry.columns));
  to.packed_rows = static_cast<int>(FANLIGHT_PACKED_ROWS(geometry.rows));
  to.left = static_cast<float>(geometry.left_mm());
  to.right_side = static_cast<float>(geometry.right_mm());
  to.first_angle = {std::cos(volume.first_angle_rad), std::sin(volume.first_angle_rad)};
  to.last_angle = {std::cos(volume.last_angle_rad), std::sin(volume.last_angle_rad)};
  to.motor_radius = static_cast<float>(geometry.motor_radius_mm);
  const double intervals = std::max(volume.frames - 1.0, 1.0);
  to.frame_angle = static_cast<float>((volume.last_angle_rad - volume.first_angle_rad) / intervals);
  to.farthest = static_cast<float>(geometry.motor_radius_mm + geometry.depth_mm());
}

/// `smoothed_pixels`: distance over which pass 0 mixes the black border of the sector into it.
void set_sector(shaders::CastParameters& to, const FanGeometry& geometry, int smoothed_pixels) {
  const FanGeometry::Sector& sector = geometry.sector;
  const double margin_mm =
      std::max(geometry.pixel_width_mm, geometry.pixel_height_mm) * (1 + smoothed_pixels);
  const auto squared = [](double value) { return static_cast<float>(value * value); };
  // Without a sector every comparison is true: its cone is wider than any frame.
  const bool known = !geometry.polar() && sector.half_angle_deg > 0;
  const double apex_mm = geometry.polar() || known ? geometry.probe_radius_mm : kFarMm;
  to.probe_radius = static_cast<float>(apex_mm);
  to.sector_tangent = static_cast<float>(known ? std::tan(radians(sector.half_angle_deg)) : kFarMm);
  to.sector_margin = static_cast<float>(known ? margin_mm : -kFarMm * kFarMm);
  to.sector_near_squared = known ? squared(apex_mm + margin_mm) : -1;
  to.sector_far_squared = squared(known && sector.reach_mm > 0 ? sector.reach_mm - margin_mm : 10 * kFarMm);
  to.least_seen_by_beam = geometry.unknown_beams ? 1 : 0;
}

glm::vec4 plane(const Scene::Clip& clip) {
  const glm::dvec3 normal(clip.normal_x, clip.normal_y, clip.normal_z);
  const double length = glm::length(normal);
  if (length == 0) return {0, 0, 0, 0};
  return {normal / length, clip.distance_mm};
}

void set_crop(shaders::CastParameters& to, const Scene& scene) {
  const Scene::Crop& crop = scene.crop;
  to.crop_lowest = {crop.left_mm, crop.near_mm, crop.below_mm};
  to.crop_highest = {crop.right_mm, crop.far_mm, crop.above_mm};
  to.clip1 = plane(scene.clip1);
  to.clip2 = plane(scene.clip2);
}

/// A part of the picture that shows the plane through `centre`, spanned by two directions.
shaders::Slice slice(const Viewport& part, const glm::dvec3& centre, const glm::dvec3& right,
                     const glm::dvec3& down) {
  const glm::dvec3 right_step = part.pixel_mm * right;
  const glm::dvec3 down_step = part.pixel_mm * down;
  return {.origin = centre - part.centre_column() * right_step - part.centre_row() * down_step,
          .right_step = right_step,
          .down_step = down_step,
          .left = part.left,
          .top = part.top,
          .width = part.width,
          .height = part.height};
}

/// Nine parallel planes, the fifth one through the target.
void set_tomography(shaders::CastParameters& to, const Scene& scene, PictureSize size) {
  constexpr std::uint32_t kAcross = 3;
  constexpr int kMiddle = 4;
  const auto [x, y, z] = plane_axes(scene.slice);
  const ViewFrame view = view_frame(scene.camera);
  struct Plane {
    glm::dvec3 right, down, normal;
  };
  const Plane planes[] = {{x, y, z}, {z, y, x}, {x, -z, y}, {view.right, -view.up, view.forward}};
  const Plane& plane = planes[static_cast<std::size_t>(scene.slice.plane)];
  for (std::uint32_t number = 0; number < kAcross * kAcross; ++number) {
    const std::uint32_t column = number % kAcross;
    const std::uint32_t row = number / kAcross;
    Viewport part{.left = column * size.width / kAcross, .top = row * size.height / kAcross};
    part.width = (column + 1) * size.width / kAcross - part.left;
    part.height = (row + 1) * size.height / kAcross - part.top;
    part.pixel_mm = scene.camera.field_mm / part.height;
    const double offset_mm = (static_cast<int>(number) - kMiddle) * scene.slice.step_mm;
    to.slice_planes[number] =
        slice(part, to_vector(scene.camera.target) + offset_mm * plane.normal, plane.right, plane.down);
  }
  to.slices = kAcross * kAcross;
}

void set_slices(shaders::CastParameters& to, const Scene& scene, PictureSize size) {
  const double field_mm = scene.camera.field_mm;
  const glm::dvec3 target = to_vector(scene.camera.target);
  const auto part = [&](std::uint32_t left, std::uint32_t top, std::uint32_t width, std::uint32_t height) {
    return Viewport{left, top, width, height, field_mm / height};
  };
  if (scene.mode == Mode::kSlice) {
    const ViewFrame view = view_frame(scene.camera);
    const double depth_mm = scene.slice.depth_mm;
    // In perspective the size of the plane in the picture depends on its distance from the eye.
    const double scale = is_perspective(scene.camera)
                             ? (depth_mm + eye_height_mm(scene.camera)) / eye_distance_mm(scene.camera)
                             : 1;
    to.slice_planes[0] = slice(part(0, 0, size.width, size.height), view.centre + depth_mm * view.forward,
                               scale * view.right, -scale * view.up);
    to.slices = scale > 0 ? 1 : 0;  // a plane behind the eye is invisible
  }
  if (scene.mode == Mode::kTomography) set_tomography(to, scene, size);
  if (scene.mode == Mode::kSlices) {
    const std::uint32_t left = size.width / 2;
    const std::uint32_t top = size.height / 2;
    const auto [x, y, z] = plane_axes(scene.slice);
    to.slice_planes[0] = slice(part(0, 0, left, top), target, x, y);
    to.slice_planes[1] = slice(part(left, 0, size.width - left, top), target, z, y);
    to.slice_planes[2] = slice(part(0, top, left, size.height - top), target, x, -z);
    to.slices = 3;
  }
}

/// Finer than a sample of a ray is of no use.
void set_slab(shaders::CastParameters& to, const Scene::Slice& slice) {
  constexpr double kMostToASide = 32;
  to.slab_kind = static_cast<int>(slice.slab);
  to.slab_samples = 1;
  if (slice.slab_mm <= 0) return;
  const double to_a_side = std::clamp(std::ceil(slice.slab_mm / 2 / to.step), 1.0, kMostToASide);
  to.slab_samples = 2 * static_cast<int>(to_a_side) + 1;
  to.slab_step = static_cast<float>(slice.slab_mm / 2 / to_a_side);
}

void set_across(shaders::CastParameters& to, int window) {
  to.across = window / 2;
  std::size_t number = 0;
  for (const glm::dvec2& point : points_across(window))
    to.across_points[number++] = {static_cast<float>(point.x), static_cast<float>(point.y)};
}

void set_segments(shaders::CastParameters& to, const Scene& scene) {
  to.segment_shift = FANLIGHT_MIN_SEGMENT_SHIFT;
  while ((to.steps - 1) >> to.segment_shift >= FANLIGHT_MAX_SEGMENTS && to.steps > 0) ++to.segment_shift;
  const TransferFunction& transfer = scene.transfer;
  const auto visible = [&](int level) { return transfer.at(level).opacity_per_mm > 0; };
  constexpr int kLevels = 256;
  int first = 0;
  while (first < kLevels && !visible(first)) ++first;
  int last = kLevels - 1;
  while (last > first && !visible(last)) --last;
  // The table is linear between two levels.
  to.least_seen = static_cast<float>((first - 1) / kGreyLevels);
  to.greatest_seen = static_cast<float>((last + 1) / kGreyLevels);
  set_across(to, scene.rays.window);
  // The direction of a layer is read from its neighbourhood (kGradientReach in shaders/glass_layers.h).
  const int beside_layers = is_glass(scene) ? std::max(scene.detector.window / 4, 1) : 0;
  to.beside = std::max(to.across, beside_layers);
}

/// What pass 1 accumulates along each ray.
int accumulation(const Scene& scene) {
  switch (scene.mode) {
    case Mode::kVolume:
    case Mode::kSurfaceAndVolume:
      return FANLIGHT_KEEP_COLOUR;
    case Mode::kMaximum:
      return FANLIGHT_KEEP_MAXIMUM;
    case Mode::kMinimum:
      return FANLIGHT_KEEP_MINIMUM;
    case Mode::kMean:
      return FANLIGHT_KEEP_MEAN;
    default:
      return is_glass(scene) ? FANLIGHT_KEEP_LAYERS : FANLIGHT_KEEP_NOTHING;
  }
}

int frames_of(const FanGeometry& geometry) {
  return geometry.polar()             ? FANLIGHT_FRAMES_POLAR
         : geometry.zero_is_unscanned ? FANLIGHT_FRAMES_MASKED
                                      : FANLIGHT_FRAMES_PARALLEL;
}

int edge_sign(EdgeSign sign) {
  return sign == EdgeSign::kDarkToBright ? 1 : sign == EdgeSign::kBrightToDark ? -1 : 0;
}

}  // namespace

Box fan_box(const FanGeometry& geometry, const VolumeExtent& volume) {
  // The fan ends at the axis: rows behind it show nothing.
  const double nearest_mm = std::max(geometry.nearest_mm(), -geometry.motor_radius_mm);
  const double straight_rad = std::clamp(0.0, volume.first_angle_rad, volume.last_angle_rad);
  Box box{.lowest = {geometry.left_mm(), HUGE_VAL, HUGE_VAL},
          .highest = {geometry.right_mm(), -HUGE_VAL, -HUGE_VAL}};
  // y and z are monotonic in rho, and the only extremum of y over the angle is at 0 deg.
  for (const double angle_rad : {volume.first_angle_rad, straight_rad, volume.last_angle_rad}) {
    for (const double depth_mm : {nearest_mm, geometry.depth_mm()}) {
      const glm::dvec3 corner = to_vector(geometry.point(0, {.angle_rad = angle_rad, .depth_mm = depth_mm}));
      box.lowest = {box.lowest.x, std::min(box.lowest.y, corner.y), std::min(box.lowest.z, corner.z)};
      box.highest = {box.highest.x, std::max(box.highest.y, corner.y), std::max(box.highest.z, corner.z)};
    }
  }
  return box;
}

CutGrid cut_grid(const FanGeometry& geometry, const VolumeExtent& volume) {
  // Not whole tens, at which many sweeps end.
  constexpr double kStepDeg = 10;
  constexpr double kFirstDeg = 3;
  const auto widened_rad = [](double angle_rad) {
    const double steps = std::ceil((degrees(angle_rad) - kFirstDeg) / kStepDeg);
    return radians(kFirstDeg + kStepDeg * std::max(steps, 0.0));
  };
  VolumeExtent wide = volume;
  wide.first_angle_rad = -widened_rad(-volume.first_angle_rad);
  wide.last_angle_rad = widened_rad(volume.last_angle_rad);
  return CutGrid::around(fan_box(geometry, wide));
}

shaders::CastParameters cast_parameters(const Scene& scene, PictureSize size, const FanGeometry& geometry,
                                        const AngleTable& table, const VolumeExtent& volume) {
  shaders::CastParameters to{};
  set_rays(to, scene, size);
  set_samples(to, scene, geometry.finest_mm(),
              farthest_depth_mm(fan_box(geometry, volume), view_frame(scene.camera)));
  set_frames(to, geometry, table, volume);
  set_sector(to, geometry, speckle_reach_pixels(scene.speckle));
  set_crop(to, scene);
  set_slices(to, scene, size);
  set_slab(to, scene.slice);
  to.threshold = static_cast<float>(scene.detector.threshold / kGreyLevels);
  to.rise = static_cast<float>(scene.detector.rise);
  to.reach = static_cast<float>(scene.detector.reach);
  to.sheet_below = static_cast<float>(scene.detector.sheet_below / kGreyLevels);
  to.least_tissue = static_cast<float>(scene.detector.least_tissue / kGreyLevels);
  to.least_contrast = static_cast<float>(scene.detector.least_contrast / kGreyLevels);
  to.edge_sign = is_glass(scene) ? 0 : edge_sign(scene.detector.sign);
  set_segments(to, scene);
  return to;
}

CastKeys cast_keys(const Scene& scene, const FanGeometry& geometry, Skipping skipping, Counting counting) {
  const int window = scene.detector.window;
  const int kept = accumulation(scene);
  const int frames = frames_of(geometry);
  // A mean or a minimum needs all samples of a ray.
  const bool skips =
      skipping == Skipping::kOn &&
      (kept == FANLIGHT_KEEP_NOTHING || kept == FANLIGHT_KEEP_COLOUR || kept == FANLIGHT_KEEP_LAYERS);
  // Where frames are replaced one by one, the tiles that a frame can have changed are cast again.
  const bool replaces_frames = scene.refresh == Refresh::kFrame && counting == Counting::kOff;
  const auto cast = [&](int tiles) {
    return PipelineKey{
        .shader = Shader::kCast,
        .constants = {window, kept, frames, static_cast<int>(scene.detector.place), scene.rays.window / 2,
                      skips ? 1 : 0, edge_sign(scene.detector.sign), tiles}};
  };
  const int all = counting == Counting::kOn ? FANLIGHT_CAST_ALL_COUNTED : FANLIGHT_CAST_ALL;
  CastKeys keys{.cast = cast(replaces_frames ? FANLIGHT_CAST_ALL_NOTED : all),
                .empty_space = {},
                .frame_steps = {},
                .slice = {},
                .cast_listed = {},
                .dirty_tiles = {}};
  if (skips) {
    keys.empty_space = PipelineKey{.shader = Shader::kEmptySpace, .constants = {window, kept, frames}};
  }
  const bool shows_depths = shown_by(scene.mode) != FANLIGHT_SHOW_COLOUR;
  if (scene.detector.frame_steps == FrameSteps::kRemoved && shows_depths)
    keys.frame_steps = PipelineKey{.shader = Shader::kFrameSteps};
  if (scene.mode == Mode::kSlice || scene.mode == Mode::kSlices || scene.mode == Mode::kTomography) {
    keys.slice = PipelineKey{.shader = Shader::kSlice, .constants = {0, 0, frames}};
  }
  if (replaces_frames && skips) {
    keys.cast_listed = cast(FANLIGHT_CAST_LISTED);
    keys.dirty_tiles = PipelineKey{.shader = Shader::kDirtyTiles,
                                   .constants = {window, 0, 0, static_cast<int>(scene.detector.place)}};
  }
  return keys;
}

PipelineKey confidence_key(const Scene& scene, const FanGeometry& geometry) {
  return {.shader = Shader::kConfidence,
          .constants = {scene.detector.window, 0, frames_of(geometry), 0, scene.rays.window / 2}};
}

TransferTable transfer_table(const TransferFunction& transfer, double step_mm) {
  TransferTable table{};
  for (std::size_t level = 0; level < table.size(); ++level) {
    const TransferFunction::Value value = transfer.at(static_cast<double>(level));
    table[level] = {value.colour[0], value.colour[1], value.colour[2],
                    1 - std::pow(1 - value.opacity_per_mm, step_mm)};
  }
  return table;
}

}  // namespace fanlight
