#include "renderer/view.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "shaders/bindings.h"
#include "shaders/prepare_constants.h"

namespace fanlight {

namespace {

constexpr double kGreyLevels = 255;
// Farther than anything.
constexpr double kFarMm = 1e4;

glm::dvec3 vector(const Point& point) {
  return {point.x_mm, point.y_mm, point.z_mm};
}

struct Box {
  glm::dvec3 lowest;
  glm::dvec3 highest;
};

/// The box around what the frames between two angles cover.
Box fan_box(const FanGeometry& geometry, const VolumeExtent& volume) {
  // The axis is the end of the fan: rows behind it show nothing.
  const double nearest_mm = std::max(geometry.nearest_mm(), -geometry.motor_radius_mm);
  const double straight_rad = std::clamp(0.0, volume.first_angle_rad, volume.last_angle_rad);
  Box box{.lowest = {geometry.left_mm(), HUGE_VAL, HUGE_VAL},
          .highest = {geometry.right_mm(), -HUGE_VAL, -HUGE_VAL}};
  // y and z are monotonic in rho, and y's only extremum over the angle is straight ahead.
  for (const double angle_rad : {volume.first_angle_rad, straight_rad, volume.last_angle_rad}) {
    for (const double depth_mm : {nearest_mm, geometry.depth_mm()}) {
      const glm::dvec3 corner = vector(geometry.point(0, {.angle_rad = angle_rad, .depth_mm = depth_mm}));
      box.lowest = {box.lowest.x, std::min(box.lowest.y, corner.y), std::min(box.lowest.z, corner.z)};
      box.highest = {box.highest.x, std::max(box.highest.y, corner.y), std::max(box.highest.z, corner.z)};
    }
  }
  return box;
}

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

bool perspective(const Scene::Camera& camera) {
  return camera.projection == Projection::kPerspective;
}

/// Height of the eye above the view plane, in perspective; negative where it lies beyond it.
double eye_height_mm(const Scene::Camera& camera) {
  return eye_distance_mm(camera) - camera.distance_mm;
}

/// The ray of pixel (column, row) goes from a point in the view plane, linear in both, in a direction linear
/// in both.
void set_rays(shaders::CastParameters& to, const Scene& scene, PictureSize size) {
  const ViewFrame view = view_frame(scene.camera);
  const Viewport port = viewport(scene, size);
  const double eye_mm = eye_distance_mm(scene.camera);
  const glm::dvec3 right_step = port.pixel_mm * view.right;
  const glm::dvec3 down_step = -port.pixel_mm * view.up;
  // From the middle of the viewport to the pixel (0, 0).
  const glm::dvec3 corner = -port.centre_column() * right_step - port.centre_row() * down_step;
  const double turn = perspective(scene.camera) ? 1 / eye_mm : 0;
  const double shrink = perspective(scene.camera) ? eye_height_mm(scene.camera) / eye_mm : 1;
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

std::array<double, 3> array(const glm::dvec3& vector) {
  return {vector.x, vector.y, vector.z};
}

void set_samples(shaders::CastParameters& to, const Scene& scene, double finest_mm, double farthest_mm) {
  const Scene::Rays& rays = scene.rays;
  const double end_mm = std::min(rays.end_mm, farthest_mm);
  const double step_mm = rays.step_mm > 0
                             ? rays.step_mm
                             : std::max(finest_mm, (end_mm - rays.start_mm) / (kMostSamplesOnARay - 1));
  // The longest ray, to a corner of the picture: below 2.7 mm a mm of depth where the picture is a square of
  // 120 deg.
  constexpr double kWidestRay = 4;
  const double widest = glm::length(glm::dvec3(to.forward));
  const double samples = std::max(0.0, (end_mm - rays.start_mm) * widest / step_mm + 1);
  to.start = static_cast<float>(rays.start_mm);
  to.end = static_cast<float>(end_mm);
  to.eye = static_cast<float>(perspective(scene.camera) ? -eye_height_mm(scene.camera) : -kFarMm);
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
  to.farthest = static_cast<float>(geometry.motor_radius_mm + geometry.depth_mm());
}

/// How many pixels away pass 0 still mixes into a pixel: the guided filter takes a mean of means.
int reach_of(const Scene::Speckle& speckle) {
  const int radius = speckle.size / 2;
  return speckle.filter == SpeckleFilter::kNone     ? 0
         : speckle.filter == SpeckleFilter::kGuided ? 2 * radius
                                                    : radius;
}

/// `smoothed_pixels`: how far pass 0 carries the black beside the sector into it.
void set_sector(shaders::CastParameters& to, const FanGeometry& geometry, int smoothed_pixels) {
  const FanGeometry::Sector& sector = geometry.sector;
  const double margin_mm =
      std::max(geometry.pixel_width_mm, geometry.pixel_height_mm) * (1 + smoothed_pixels);
  const auto squared = [](double value) { return static_cast<float>(value * value); };
  // Without a sector every comparison holds: its cone is wider than any frame.
  const bool known = !geometry.polar() && sector.half_angle_deg > 0;
  const double apex_mm = geometry.polar() || known ? geometry.probe_radius_mm : kFarMm;
  to.probe_radius = static_cast<float>(apex_mm);
  to.sector_tangent = static_cast<float>(known ? std::tan(radians(sector.half_angle_deg)) : kFarMm);
  to.sector_margin = static_cast<float>(known ? margin_mm : -kFarMm * kFarMm);
  to.sector_near_squared = known ? squared(apex_mm + margin_mm) : -1;
  to.sector_far_squared = squared(known && sector.reach_mm > 0 ? sector.reach_mm - margin_mm : 10 * kFarMm);
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

/// A part of the picture that shows the plane through `centre` along two directions.
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

void set_slices(shaders::CastParameters& to, const Scene& scene, PictureSize size) {
  const double field_mm = scene.camera.field_mm;
  const glm::dvec3 target = vector(scene.camera.target);
  const auto part = [&](std::uint32_t left, std::uint32_t top, std::uint32_t width, std::uint32_t height) {
    return Viewport{left, top, width, height, field_mm / height};
  };
  if (scene.mode == Mode::kSlice) {
    const ViewFrame view = view_frame(scene.camera);
    const double depth_mm = scene.slice.depth_mm;
    // In perspective the plane shows as large as its distance from the eye makes it.
    const double scale = perspective(scene.camera)
                             ? (depth_mm + eye_height_mm(scene.camera)) / eye_distance_mm(scene.camera)
                             : 1;
    to.slice_planes[0] = slice(part(0, 0, size.width, size.height), view.centre + depth_mm * view.forward,
                               scale * view.right, -scale * view.up);
    to.slices = scale > 0 ? 1 : 0;  // a plane behind the eye is not seen
  }
  if (scene.mode == Mode::kSlices) {
    const std::uint32_t left = size.width / 2;
    const std::uint32_t top = size.height / 2;
    const glm::dvec3 x(1, 0, 0);
    const glm::dvec3 y(0, 1, 0);
    const glm::dvec3 z(0, 0, 1);
    to.slice_planes[0] = slice(part(0, 0, left, top), target, x, y);
    to.slice_planes[1] = slice(part(left, 0, size.width - left, top), target, z, y);
    to.slice_planes[2] = slice(part(0, top, left, size.height - top), target, x, -z);
    to.slices = 3;
  }
}

/// Of a colour as displayed (sRGB).
glm::vec3 linear(double red, double green, double blue) {
  const auto decoded = [](double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  return {decoded(red), decoded(green), decoded(blue)};
}

void set_viewport(shaders::LightParameters& to, const Scene& scene, PictureSize size) {
  const Viewport port = viewport(scene, size);
  to.width = size.width;
  to.height = size.height;
  to.view_left = static_cast<int>(port.left);
  to.view_top = static_cast<int>(port.top);
  to.view_right = static_cast<int>(port.left + port.width) - 1;
  to.view_bottom = static_cast<int>(port.top + port.height) - 1;
  to.centre = {port.centre_column(), port.centre_row()};
  to.pixel = static_cast<float>(port.pixel_mm);
  const double eye_mm = eye_distance_mm(scene.camera);
  const double height_mm = eye_height_mm(scene.camera);
  const bool from_eye = perspective(scene.camera);
  to.view_scale_at_0 = static_cast<float>(from_eye ? height_mm / eye_mm : 1);
  to.view_scale_per_mm = static_cast<float>(from_eye ? 1 / eye_mm : 0);
  to.eye_height = static_cast<float>(height_mm);
  // A millimetre before the eye, where that lies beyond the view plane: nothing is nearer.
  to.shadow_top =
      static_cast<float>(from_eye ? -std::max(scene.rays.start_mm, 1 - height_mm) : -scene.rays.start_mm);
}

void set_filter(shaders::LightParameters& to, const Scene& scene, double farthest_mm) {
  const Scene::Filter& filter = scene.filter;
  to.steady = static_cast<float>(filter.steady);
  to.same_surface = static_cast<float>(filter.step_mm);
  to.islands_radius = filter.islands / 2;
  to.holes_radius = filter.holes / 2;
  to.filter_radius = filter.size / 2;
  const double sigma_pixels = filter.size / 5.0;
  to.filter_fall = static_cast<float>(1 / (2 * sigma_pixels * sigma_pixels));
  to.confidence_counts = filter.weights == FilterWeights::kConfidence ? 1 : 0;
  // The largest sum: a whole window of the deepest surface, with the largest weight.
  const int most_weight = to.confidence_counts != 0 ? FANLIGHT_MOST_WEIGHT : 1;
  const double largest_mm =
      std::max(farthest_mm - scene.rays.start_mm, 1.0) * filter.size * filter.size * most_weight;
  constexpr double kFinestUnits = 16384;
  to.sum_units = static_cast<float>(std::min(4.0e9 / largest_mm, kFinestUnits));
}

void set_light(shaders::LightParameters& to, const Scene& scene) {
  const Scene::Light& light = scene.light;
  to.light = {light.right_mm, light.up_mm, -light.depth_mm};
  const glm::dvec3 from_target(light.right_mm, light.up_mm, scene.camera.distance_mm - light.depth_mm);
  const double distance_mm = glm::length(from_target);
  to.light_direction = distance_mm > 0 ? from_target / distance_mm : glm::dvec3(0, 0, 1);
  to.lamp_distance = static_cast<float>(std::max(distance_mm, 1e-3));
  to.directional = light.kind == LightKind::kDirectional ? 1 : 0;
  to.light_colour = linear(light.red, light.green, light.blue);
  to.material = linear(scene.material.red, scene.material.green, scene.material.blue);
  to.ambient = static_cast<float>(light.ambient);
  to.diffuse = static_cast<float>(light.diffuse);
  to.specular = static_cast<float>(light.specular);
  to.shininess = static_cast<float>(light.shininess);
  to.central_normals = light.normals == Normals::kCentral ? 1 : 0;
  to.shadow = static_cast<float>(scene.shadow.coefficient);
  to.softness = static_cast<float>(scene.shadow.softness_mm);
}

void set_segments(shaders::CastParameters& to, const Scene& scene) {
  to.segment_shift = FANLIGHT_LEAST_SEGMENT_SHIFT;
  while ((to.steps - 1) >> to.segment_shift >= FANLIGHT_MOST_SEGMENTS && to.steps > 0) ++to.segment_shift;
  const TransferFunction& transfer = scene.transfer;
  const auto seen = [&](int level) { return transfer.at(level).opacity_per_mm > 0; };
  constexpr int kLevels = 256;
  int first = 0;
  while (first < kLevels && !seen(first)) ++first;
  int last = kLevels - 1;
  while (last > first && !seen(last)) --last;
  // Between two levels the table is linear.
  to.least_seen = static_cast<float>((first - 1) / kGreyLevels);
  to.greatest_seen = static_cast<float>((last + 1) / kGreyLevels);
  to.across = scene.rays.window / 2;
}

int shown_by(Mode mode) {
  switch (mode) {
    case Mode::kSurface:
    case Mode::kSurfaceAndVolume:
    case Mode::kSlices:
      return FANLIGHT_SHOW_SURFACE;
    case Mode::kDepth:
      return FANLIGHT_SHOW_DEPTH;
    default:
      return FANLIGHT_SHOW_COLOUR;
  }
}

}  // namespace

ViewFrame view_frame(const Scene::Camera& camera) {
  const double yaw = radians(camera.yaw_deg);
  const double pitch = radians(camera.pitch_deg);
  const double roll = radians(camera.roll_deg);
  const glm::dvec3 forward(-std::sin(yaw) * std::cos(pitch), std::cos(yaw) * std::cos(pitch),
                           -std::sin(pitch));
  const glm::dvec3 level(std::cos(yaw), std::sin(yaw), 0);
  const glm::dvec3 upright = glm::cross(level, forward);
  // A camera that turns clockwise dips its right side.
  return {.centre = vector(camera.target) - camera.distance_mm * forward,
          .right = std::cos(roll) * level - std::sin(roll) * upright,
          .up = std::cos(roll) * upright + std::sin(roll) * level,
          .forward = forward};
}

Viewport viewport(const Scene& scene, PictureSize size) {
  Viewport port{.width = size.width, .height = size.height};
  if (scene.mode == Mode::kSlice) port.width = 0;
  if (scene.mode == Mode::kSurfaceAndVolume) port.width = size.width / 2;
  if (scene.mode == Mode::kSlices) {
    port.left = size.width / 2;
    port.top = size.height / 2;
    port.width -= port.left;
    port.height -= port.top;
  }
  // Beside the volume the surface has a narrow part: the field is then its width.
  const std::uint32_t side =
      scene.mode == Mode::kSurfaceAndVolume ? std::min(port.width, port.height) : port.height;
  port.pixel_mm = scene.camera.field_mm / side;
  return port;
}

double eye_distance_mm(const Scene::Camera& camera) {
  return camera.field_mm / (2 * std::tan(radians(camera.opening_deg) / 2));
}

int kept_by(Mode mode) {
  switch (mode) {
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
      return FANLIGHT_KEEP_NOTHING;
  }
}

PictureView picture_view(const Scene& scene, PictureSize size) {
  const ViewFrame view = view_frame(scene.camera);
  const Viewport port = viewport(scene, size);
  const double eye_mm = eye_distance_mm(scene.camera);
  const bool widens = perspective(scene.camera);
  return {.origin_mm = array(view.centre),
          .right = array(view.right),
          .down = array(-view.up),
          .forward = array(view.forward),
          .mm_per_pixel = port.pixel_mm * (widens ? eye_height_mm(scene.camera) / eye_mm : 1),
          .mm_per_pixel_per_mm = widens ? port.pixel_mm / eye_mm : 0,
          .middle_column = port.centre_column(),
          .middle_row = port.centre_row()};
}

shaders::CastParameters cast_parameters(const Scene& scene, PictureSize size, const FanGeometry& geometry,
                                        const AngleTable& table, const VolumeExtent& volume) {
  shaders::CastParameters to{};
  set_rays(to, scene, size);
  set_samples(to, scene, geometry.finest_mm(),
              farthest_depth_mm(fan_box(geometry, volume), view_frame(scene.camera)));
  set_frames(to, geometry, table, volume);
  set_sector(to, geometry, reach_of(scene.speckle));
  set_crop(to, scene);
  set_slices(to, scene, size);
  to.threshold = static_cast<float>(scene.detector.threshold / kGreyLevels);
  to.edge_sign = scene.detector.sign == EdgeSign::kDarkToBright   ? 1
                 : scene.detector.sign == EdgeSign::kBrightToDark ? -1
                                                                  : 0;
  set_segments(to, scene);
  return to;
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

shaders::LightParameters light_parameters(const Scene& scene, PictureSize size, double farthest_mm) {
  shaders::LightParameters to{};
  set_viewport(to, scene, size);
  set_filter(to, scene, farthest_mm);
  set_light(to, scene);
  to.show = shown_by(scene.mode);
  to.colours_from_left = scene.mode == Mode::kSurfaceAndVolume ? static_cast<int>(size.width / 2) : 0;
  to.depth_white = static_cast<float>(scene.rays.start_mm);
  to.depth_scale = static_cast<float>(1 / (scene.rays.end_mm - scene.rays.start_mm));
  to.mean = scene.finish.smoothing == Smoothing::kMean ? 1 : 0;
  to.diffusion_scale = static_cast<float>(kGreyLevels / scene.finish.conductance);
  to.map_colours = scene.finish.colours == ColourMap::kNone ? 0 : 1;
  const auto points = colour_map_points(scene.finish.colours);
  std::ranges::copy(points, std::begin(to.map_points));
  return to;
}

std::array<glm::dvec3, FANLIGHT_MAP_POINTS> colour_map_points(ColourMap map) {
  const glm::dvec3 black(0, 0, 0);
  switch (map) {
    case ColourMap::kSepia:
      return {black, {0.29, 0.20, 0.13}, {0.69, 0.56, 0.40}, {1.00, 0.95, 0.84}};
    case ColourMap::kGold:
      return {black, {0.45, 0.20, 0.02}, {0.85, 0.55, 0.12}, {1.00, 0.95, 0.70}};
    case ColourMap::kIce:
      return {black, {0.05, 0.22, 0.45}, {0.35, 0.62, 0.85}, {0.92, 0.98, 1.00}};
    case ColourMap::kHeat:
      return {black, {0.55, 0.00, 0.00}, {1.00, 0.55, 0.00}, {1.00, 1.00, 0.85}};
    case ColourMap::kNone:
    case ColourMap::kGrey:
      break;
  }
  return {black, glm::dvec3(1.0 / 3), glm::dvec3(2.0 / 3), glm::dvec3(1)};
}

}  // namespace fanlight
