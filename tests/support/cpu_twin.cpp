#include "tests/support/cpu_twin.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace fanlight::test {

namespace {

using glm::dvec3;

/// The frame coordinate of an angle among the frames in ascending order, or nothing outside them.
std::optional<double> frame_coordinate(const Volume& volume, double angle_rad) {
  const auto order = volume.by_angle();
  const auto angle = [&](std::size_t place) { return volume.angles_rad()[order[place]]; };
  if (angle_rad < angle(0) || angle_rad > angle(order.size() - 1)) return std::nullopt;
  std::size_t below = 0;
  while (below + 2 < order.size() && angle(below + 1) <= angle_rad) ++below;
  const double step = angle(below + 1) - angle(below);
  return static_cast<double>(below) + (step > 0 ? (angle_rad - angle(below)) / step : 0);
}

double voxel(const Volume& volume, int column, int row, int place) {
  const FanGeometry& geometry = volume.geometry();
  const int last_frame = static_cast<int>(volume.by_angle().size()) - 1;
  column = std::clamp(column, 0, static_cast<int>(geometry.columns) - 1);
  row = std::clamp(row, 0, static_cast<int>(geometry.rows) - 1);
  const auto frame = volume.frame_pixels(volume.by_angle()[std::clamp(place, 0, last_frame)]);
  return frame[static_cast<std::size_t>(row) * geometry.columns + static_cast<std::size_t>(column)] / 255.0;
}

bool in_sector(const FanGeometry& geometry, double x_mm, double depth_mm) {
  const FanGeometry::Sector& sector = geometry.sector;
  if (sector.half_angle_deg == 0) return true;
  const double margin_mm = std::max(geometry.pixel_width_mm, geometry.pixel_height_mm);
  const double from_apex_mm = depth_mm + sector.probe_radius_mm;
  const double reach_mm = std::hypot(x_mm, from_apex_mm);
  return std::abs(x_mm) + margin_mm <= from_apex_mm * std::tan(radians(sector.half_angle_deg)) &&
         reach_mm >= sector.probe_radius_mm + margin_mm &&
         (sector.reach_mm == 0 || reach_mm <= sector.reach_mm - margin_mm);
}

/// The echo at a point, 0 to 1, trilinear between the nearest pixels of the nearest frames; nothing where
/// nothing was scanned.
std::optional<double> echo(const Volume& volume, const dvec3& at) {
  const FanGeometry& geometry = volume.geometry();
  const FanCoordinate fan = geometry.fan_coordinate(at.y, at.z);
  const auto frame = frame_coordinate(volume, fan.angle_rad);
  const double column = at.x / geometry.pixel_width_mm + geometry.face_column;
  const double row = fan.depth_mm / geometry.pixel_height_mm + geometry.face_row;
  if (!frame || column < 0 || column > geometry.columns - 1 || row < 0 || row > geometry.rows - 1 ||
      !in_sector(geometry, at.x, fan.depth_mm)) {
    return std::nullopt;
  }
  const dvec3 base(std::floor(column), std::floor(row), std::floor(*frame));
  const dvec3 share = dvec3(column, row, *frame) - base;
  double value = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int right = corner & 1;
    const int down = corner >> 1 & 1;
    const int next = corner >> 2;
    const double weight = (right != 0 ? share.x : 1 - share.x) * (down != 0 ? share.y : 1 - share.y) *
                          (next != 0 ? share.z : 1 - share.z);
    value += weight * voxel(volume, static_cast<int>(base.x) + right, static_cast<int>(base.y) + down,
                            static_cast<int>(base.z) + next);
  }
  return value;
}

dvec3 tissue_colour(double value) {
  return (1 - value) * dvec3(0.35, 0.12, 0.08) + value * dvec3(1.0, 0.92, 0.82);
}

struct TwinRay {
  double depth_mm = kNoSurface;
  dvec3 colour{0};
};

TwinRay twin_ray(const Scene& scene, const Volume& volume, const dvec3& on_plane, const dvec3& forward) {
  const FanGeometry& geometry = volume.geometry();
  const double step_mm = scene.rays.step_mm > 0 ? scene.rays.step_mm
                                                : std::min(geometry.pixel_width_mm, geometry.pixel_height_mm);
  const int steps = static_cast<int>((scene.rays.end_mm - scene.rays.start_mm) / step_mm) + 1;
  const int window = scene.detector.window;
  const double threshold = scene.detector.threshold / 255;
  const double step_opacity = 1 - std::pow(1 - scene.transfer.opacity_per_mm, step_mm);
  const bool composite = scene.mode == Mode::kVolume;

  TwinRay ray;
  double opacity = 0;
  std::vector<double> samples;  // of the scanned stretch under way
  double last_edge = 0;
  for (int index = 0; index < steps; ++index) {
    const auto value = echo(volume, on_plane + (scene.rays.start_mm + index * step_mm) * forward);
    if (!value) {
      samples.clear();
      continue;
    }
    samples.push_back(*value);
    if (static_cast<int>(samples.size()) >= window && ray.depth_mm < 0) {
      double difference = 0;
      for (int back = 0; back < window; ++back) {
        difference +=
            (back < window / 2 ? 1 : -1) * samples[samples.size() - 1 - static_cast<std::size_t>(back)];
      }
      difference *= 2.0 / window;
      const double edge = scene.detector.sign == EdgeSign::kEither         ? std::abs(difference)
                          : scene.detector.sign == EdgeSign::kDarkToBright ? difference
                                                                           : -difference;
      if (edge > threshold) {
        const bool first = static_cast<int>(samples.size()) == window;
        const double beyond =
            first || edge <= last_edge ? 0 : std::clamp((edge - threshold) / (edge - last_edge), 0.0, 1.0);
        ray.depth_mm = scene.rays.start_mm + (index - window / 2 + 0.5 - beyond) * step_mm;
        if (!composite) return ray;
      }
      last_edge = edge;
    }
    if (composite) {
      const double ramp =
          (*value * 255 - scene.transfer.transparent) / (scene.transfer.opaque - scene.transfer.transparent);
      const double share = std::clamp(ramp, 0.0, 1.0) * step_opacity;
      ray.colour += (1 - opacity) * share * tissue_colour(*value);
      opacity += (1 - opacity) * share;
    }
  }
  return ray;
}

}  // namespace

TwinCast twin_cast(const Scene& scene, PictureSize size, const Volume& volume) {
  const ViewFrame view = view_frame(scene.camera);
  const double pixel = pixel_mm(scene.camera, size);
  TwinCast cast;
  for (std::uint32_t row = 0; row < size.height; ++row) {
    for (std::uint32_t column = 0; column < size.width; ++column) {
      const double right_mm = (column - 0.5 * (size.width - 1.0)) * pixel;
      const double up_mm = (0.5 * (size.height - 1.0) - row) * pixel;
      const TwinRay ray =
          twin_ray(scene, volume, view.centre + right_mm * view.right + up_mm * view.up, view.forward);
      cast.depth_mm.push_back(ray.depth_mm);
      cast.colour.push_back({ray.colour.x, ray.colour.y, ray.colour.z});
    }
  }
  return cast;
}

std::vector<double> twin_filter(const std::vector<double>& depth_mm, PictureSize size, int filter_size) {
  const int width = static_cast<int>(size.width);
  const int height = static_cast<int>(size.height);
  const int radius = filter_size / 2;
  std::vector<double> smooth_mm(depth_mm.size(), kNoSurface);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      if (depth_mm[static_cast<std::size_t>(row * width + column)] < 0) continue;
      double sum = 0;
      int count = 0;
      for (int y = std::max(0, row - radius); y <= std::min(height - 1, row + radius); ++y) {
        for (int x = std::max(0, column - radius); x <= std::min(width - 1, column + radius); ++x) {
          const double depth = depth_mm[static_cast<std::size_t>(y * width + x)];
          if (depth < 0) continue;
          sum += depth;
          ++count;
        }
      }
      smooth_mm[static_cast<std::size_t>(row * width + column)] = sum / count;
    }
  }
  return smooth_mm;
}

namespace {

/// The height map of pass 2 in the view frame: right, up, height (towards the viewer, -depth), mm.
class HeightMap {
 public:
  HeightMap(const std::vector<double>& depth_mm, PictureSize size, double pixel)
      : depth_mm_(depth_mm),
        width_(static_cast<int>(size.width)),
        height_(static_cast<int>(size.height)),
        pixel_(pixel) {}

  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  double depth(int x, int y) const {
    return inside(x, y) ? depth_mm_[static_cast<std::size_t>(y * width_ + x)] : kNoSurface;
  }

  dvec3 place(int x, int y) const {
    return {(x - 0.5 * (width_ - 1)) * pixel_, (0.5 * (height_ - 1) - y) * pixel_, -depth(x, y)};
  }

  /// Of the depth, per mm, from three neighbouring pixels: the next one where it has a surface, else the
  /// last.
  double slope(int x, int y, int dx, int dy) const {
    if (depth(x + dx, y + dy) >= 0) return (depth(x + dx, y + dy) - depth(x, y)) / pixel_;
    if (depth(x - dx, y - dy) >= 0) return (depth(x, y) - depth(x - dx, y - dy)) / pixel_;
    return 0;
  }

  bool shadowed(int x, int y, const dvec3& light, double top_mm) const {
    const dvec3 from = place(x, y);
    const double across = (light.x - from.x) / pixel_;
    const double down = (from.y - light.y) / pixel_;
    const double pixels = std::max(std::abs(across), std::abs(down));
    if (pixels < 1) return false;
    constexpr double kBiasPixels = 1.5;
    for (double walked = 1; walked < pixels; walked += 1) {
      const double at_x = x + across / pixels * walked;
      const double at_y = y + down / pixels * walked;
      const double height = from.z + kBiasPixels * pixel_ + (light.z - from.z) / pixels * walked;
      if (height > top_mm || at_x < 0 || at_y < 0 || at_x > width_ - 1 || at_y > height_ - 1) return false;
      const double depth_there = depth(static_cast<int>(at_x + 0.5), static_cast<int>(at_y + 0.5));
      if (depth_there >= 0 && -depth_there > height) return true;
    }
    return false;
  }

 private:
  const std::vector<double>& depth_mm_;
  int width_;
  int height_;
  double pixel_;
};

double encoded(double linear) {
  const double bounded = std::clamp(linear, 0.0, 1.0);
  return bounded < 0.0031308 ? 12.92 * bounded : 1.055 * std::pow(bounded, 1 / 2.4) - 0.055;
}

}  // namespace

std::vector<Rgb> twin_light(const std::vector<double>& smooth_mm, PictureSize size, const Scene& scene) {
  const HeightMap map(smooth_mm, size, pixel_mm(scene.camera, size));
  const dvec3 light(scene.light.right_mm, scene.light.up_mm, -scene.light.depth_mm);
  const dvec3 skin(0.90, 0.58, 0.42);
  std::vector<Rgb> lit(smooth_mm.size(), Rgb{0, 0, 0});
  for (int y = 0; y < static_cast<int>(size.height); ++y) {
    for (int x = 0; x < static_cast<int>(size.width); ++x) {
      if (map.depth(x, y) < 0) continue;
      const dvec3 normal = glm::normalize(dvec3(map.slope(x, y, 1, 0), -map.slope(x, y, 0, 1), 1));
      const dvec3 to_light = glm::normalize(light - map.place(x, y));
      const dvec3 halfway = glm::normalize(to_light + dvec3(0, 0, 1));
      const double facing = std::max(glm::dot(normal, to_light), 0.0);
      const double gleam =
          facing > 0 ? std::pow(std::max(glm::dot(normal, halfway), 0.0), scene.light.shininess) : 0;
      const bool hidden =
          facing > 0 && scene.shadow.coefficient < 1 && map.shadowed(x, y, light, -scene.rays.start_mm);
      const dvec3 colour =
          (hidden ? scene.shadow.coefficient : 1.0) *
          (skin * (scene.light.ambient + scene.light.diffuse * facing) + dvec3(scene.light.specular * gleam));
      lit[static_cast<std::size_t>(y) * size.width + static_cast<std::size_t>(x)] = {
          encoded(colour.x), encoded(colour.y), encoded(colour.z)};
    }
  }
  return lit;
}

std::vector<Rgb> twin_finish(const std::vector<Rgb>& lit, PictureSize size, Finish finish) {
  if (finish == Finish::kNone) return lit;
  std::vector<Rgb> finished(lit.size());
  for (std::size_t y = 0; y < size.height; ++y) {
    for (std::size_t x = 0; x < size.width; ++x) {
      const std::size_t right = std::min<std::size_t>(x + 1, size.width - 1);
      const std::size_t below = std::min<std::size_t>(y + 1, size.height - 1);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        finished[y * size.width + x][channel] =
            0.25 * (lit[y * size.width + x][channel] + lit[y * size.width + right][channel] +
                    lit[below * size.width + x][channel] + lit[below * size.width + right][channel]);
      }
    }
  }
  return finished;
}

}  // namespace fanlight::test
