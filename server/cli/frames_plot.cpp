// SPDX-License-Identifier: Apache-2.0
#include "server/cli/frames_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr std::uint32_t kSide = 900;
constexpr std::uint32_t kMargin = 40;
constexpr std::size_t kMostFrames = 11;
constexpr double kYawRad = radians(50);
constexpr double kPitchRad = radians(25);

using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kGreen = {90, 230, 120};
constexpr Colour kGrey = {130, 140, 150};
constexpr Colour kViolet = {183, 156, 255};

struct Place {
  double right;
  double down;
  double away;
};

/// From the side and above: x goes to the lower right, z to the upper right, y down.
Place seen(const Point& point) {
  const double along = point.x_mm * std::cos(kYawRad) + point.z_mm * std::sin(kYawRad);
  const double across = -point.x_mm * std::sin(kYawRad) + point.z_mm * std::cos(kYawRad);
  return {.right = along,
          .down = point.y_mm * std::cos(kPitchRad) - across * std::sin(kPitchRad),
          .away = point.y_mm * std::sin(kPitchRad) + across * std::cos(kPitchRad)};
}

/// A picture with a depth for each pixel.
class Canvas {
 public:
  Canvas() : picture_(blank_picture(kSide, kSide)), nearest_(std::size_t{kSide} * kSide, kFar) {}

  /// What is drawn later must lie within these bounds.
  void fit(std::span<const Place> places) {
    double least[2] = {kFar, kFar};
    double most[2] = {-kFar, -kFar};
    for (const Place& place : places) {
      least[0] = std::min(least[0], place.right);
      most[0] = std::max(most[0], place.right);
      least[1] = std::min(least[1], place.down);
      most[1] = std::max(most[1], place.down);
    }
    const double extent = std::max({most[0] - least[0], most[1] - least[1], 1e-6});
    scale_ = (kSide - 2.0 * kMargin) / extent;
    left_ = kSide / 2.0 - scale_ * (least[0] + most[0]) / 2;
    top_ = kSide / 2.0 - scale_ * (least[1] + most[1]) / 2;
  }
  double pixel_mm() const { return 1 / scale_; }

  void dot(const Place& place, const Colour& colour, double nearer_mm = 0) {
    const double column = std::round(left_ + scale_ * place.right);
    const double row = std::round(top_ + scale_ * place.down);
    if (!(column >= 0 && column < kSide && row >= 0 && row < kSide)) return;
    const std::size_t pixel = static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(column);
    const double away = place.away - nearer_mm;
    if (away > nearest_[pixel]) return;
    nearest_[pixel] = away;
    std::ranges::copy(colour, picture_.rgba.begin() + static_cast<std::ptrdiff_t>(4 * pixel));
    picture_.rgba[4 * pixel + 3] = 255;
  }
  void line(const Place& from, const Place& to, const Colour& colour, double nearer_mm) {
    const double length = scale_ * std::hypot(to.right - from.right, to.down - from.down);
    const int steps = std::max(1, static_cast<int>(std::ceil(length)));
    for (int i = 0; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      dot({std::lerp(from.right, to.right, share), std::lerp(from.down, to.down, share),
           std::lerp(from.away, to.away, share)},
          colour, nearer_mm);
    }
  }
  Picture take() { return std::move(picture_); }

 private:
  static constexpr double kFar = std::numeric_limits<double>::max();
  Picture picture_;
  std::vector<double> nearest_;
  double scale_ = 1;
  double left_ = 0;
  double top_ = 0;
};

/// The frames of one sweep in space.
class SweepDrawing {
 public:
  SweepDrawing(Recording& recording) : recording_(recording), geometry_(recording.summary().geometry) {}

  Result<Picture> draw() {
    const auto& sweeps = recording_.sweeps();
    const auto longest = std::ranges::max_element(sweeps, {}, &Recording::Sweep::frames);
    std::vector<std::uint32_t> chosen;
    const std::size_t count = std::min<std::size_t>(kMostFrames, longest->frames);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t in_sweep = count == 1 ? 0 : i * (longest->frames - 1) / (count - 1);
      chosen.push_back(longest->first_frame + static_cast<std::uint32_t>(in_sweep));
    }
    fit(chosen);
    std::vector<std::uint8_t> pixels(geometry_.frame_bytes());
    for (const std::uint32_t frame : chosen) {
      if (auto read = recording_.read_frame(frame, pixels); !read) return read.error();
      draw_frame(recording_.frames()[frame].angle_rad, pixels);
    }
    if (shows_axis()) draw_axis();
    return canvas_.take();
  }

 private:
  Place place(FramePlace at, double angle_rad) const {
    const PlanePoint in_plane = geometry_.plane_point(at);
    return seen(geometry_.point(in_plane.x_mm, {.angle_rad = angle_rad, .depth_mm = in_plane.depth_mm}));
  }

  /// Corners and middles of the border.
  std::vector<FramePlace> border() const {
    constexpr int kSteps = 24;
    const double right = geometry_.columns - 1.0;
    const double bottom = geometry_.rows - 1.0;
    std::vector<FramePlace> places;
    places.reserve(4 * kSteps + 1);
    for (int i = 0; i < kSteps; ++i) places.push_back({right * i / kSteps, 0});
    for (int i = 0; i < kSteps; ++i) places.push_back({right, bottom * i / kSteps});
    for (int i = 0; i < kSteps; ++i) places.push_back({right - right * i / kSteps, bottom});
    for (int i = 0; i <= kSteps; ++i) places.push_back({0, bottom - bottom * i / kSteps});
    return places;
  }

  void fit(std::span<const std::uint32_t> chosen) {
    std::vector<Place> places;
    for (const std::uint32_t frame : chosen) {
      for (const FramePlace& at : border()) places.push_back(place(at, recording_.frames()[frame].angle_rad));
    }
    if (shows_axis()) {
      for (const double x_mm : {geometry_.left_mm(), geometry_.right_mm()})
        places.push_back(seen({x_mm, -geometry_.motor_radius_mm, 0}));
    }
    canvas_.fit(places);
  }

  bool scanned(const PlanePoint& at) const {
    if (geometry_.sector.half_angle_deg == 0) return true;
    const double from_apex_mm = at.depth_mm + geometry_.probe_radius_mm;
    return std::abs(std::atan2(at.x_mm, from_apex_mm)) <= radians(geometry_.sector.half_angle_deg);
  }

  void draw_frame(double angle_rad, std::span<const std::uint8_t> pixels) {
    // Dense enough to leave no holes.
    const double step = std::clamp(canvas_.pixel_mm() / geometry_.finest_mm() / 2, 0.25, 4.0);
    for (double row = 0; row <= geometry_.rows - 1; row += step) {
      for (double column = 0; column <= geometry_.columns - 1; column += step) {
        const std::uint8_t grey =
            pixels[static_cast<std::size_t>(row) * geometry_.columns + static_cast<std::size_t>(column)];
        constexpr std::uint8_t kTransparent = 40;
        if (grey < kTransparent || !scanned(geometry_.plane_point({column, row}))) continue;
        // Bright pixels show through darker ones.
        canvas_.dot(place({column, row}, angle_rad), {grey, grey, grey}, grey / 255.0 * 1000);
      }
    }
    const auto places = border();
    constexpr double kInFront = 2000;
    for (std::size_t i = 0; i + 1 < places.size(); ++i)
      canvas_.line(place(places[i], angle_rad), place(places[i + 1], angle_rad), kGrey, kInFront);
    draw_face(angle_rad);
  }

  void draw_face(double angle_rad) {
    const double radius_mm = geometry_.probe_radius_mm;
    const double half_rad =
        geometry_.polar() ? std::abs(geometry_.line_angle_rad(0)) : radians(geometry_.sector.half_angle_deg);
    std::vector<Place> face;
    for (int i = -20; i <= 20; ++i) {
      PlanePoint at{.x_mm = geometry_.right_mm() * i / 20};
      if (radius_mm > 0 && half_rad > 0) {
        at = {.x_mm = radius_mm * std::sin(half_rad * i / 20),
              .depth_mm = radius_mm * (std::cos(half_rad * i / 20) - 1)};
      }
      face.push_back(seen(geometry_.point(at.x_mm, {.angle_rad = angle_rad, .depth_mm = at.depth_mm})));
    }
    for (std::size_t i = 0; i + 1 < face.size(); ++i) canvas_.line(face[i], face[i + 1], kGreen, 3000);
  }

  /// That of a volume on a grid lies so far away that nothing else would be seen.
  bool shows_axis() const {
    constexpr double kFarMm = 500;
    return geometry_.motor_radius_mm < kFarMm;
  }

  void draw_axis() {
    canvas_.line(seen({geometry_.left_mm(), -geometry_.motor_radius_mm, 0}),
                 seen({geometry_.right_mm(), -geometry_.motor_radius_mm, 0}), kViolet, 4000);
  }

  Recording& recording_;
  const FanGeometry& geometry_;
  Canvas canvas_;
};

void put(Picture& picture, double column, double row, const Colour& colour) {
  if (!(column >= 0 && column < picture.width && row >= 0 && row < picture.height)) return;
  const std::size_t pixel = static_cast<std::size_t>(row) * picture.width + static_cast<std::size_t>(column);
  std::ranges::copy(colour, picture.rgba.begin() + static_cast<std::ptrdiff_t>(4 * pixel));
}

void draw_sector(Picture& picture, const FileFacts& facts, std::uint32_t left) {
  const SectorGuess& sector = *facts.sector;
  // Lines may not enter the frame next to theirs.
  const auto dot = [&](double column, double row, const Colour& colour) {
    if (column >= 0 && column < facts.columns) put(picture, left + column, row, colour);
  };
  if (!sector.diverges) {
    for (double row = sector.face_row; row <= sector.last_row; ++row) {
      dot(sector.left_column, row, kGreen);
      dot(sector.right_column, row, kGreen);
    }
    for (double column = sector.left_column; column <= sector.right_column; ++column) {
      dot(column, sector.face_row, kGreen);
      dot(column, sector.last_row, kGrey);
    }
    return;
  }
  const double column_rows = facts.pixel_size ? facts.pixel_size->width_mm / facts.pixel_size->height_mm : 1;
  const auto polar = [&](double radius, double rad, const Colour& colour) {
    dot(sector.face_column + radius * std::sin(rad) / column_rows, sector.apex_row + radius * std::cos(rad),
        colour);
  };
  const double half_rad = radians(sector.half_angle_deg);
  const double face = sector.face_row - sector.apex_row;
  const double end = sector.last_row - sector.apex_row;
  for (double radius = face; radius <= end; radius += 0.5) {
    polar(radius, -half_rad, kGreen);
    polar(radius, half_rad, kGreen);
  }
  for (double rad = -half_rad; rad <= half_rad; rad += 0.5 / end) {
    polar(face, rad, kGreen);
    polar(end, rad, kGrey);
  }
}

}  // namespace

Result<Picture> frames_in_space(Recording& recording) {
  return SweepDrawing(recording).draw();
}

Picture frames_side_by_side(const FileFacts& facts) {
  constexpr std::uint32_t kGap = 8;
  Picture picture = blank_picture(2 * facts.columns + kGap, facts.rows);
  std::uint32_t left = 0;
  for (const auto* const frame : {&facts.first_frame, &facts.middle_frame}) {
    for (std::uint32_t row = 0; row < facts.rows; ++row) {
      for (std::uint32_t column = 0; column < facts.columns; ++column) {
        const std::uint8_t grey = (*frame)[std::size_t{row} * facts.columns + column];
        put(picture, left + column, row, {grey, grey, grey});
      }
    }
    if (facts.sector) draw_sector(picture, facts, left);
    left += facts.columns + kGap;
  }
  return picture;
}

}  // namespace fanlight
