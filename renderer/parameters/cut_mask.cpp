// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/cut_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>

namespace fanlight {

namespace {

constexpr double kLeastCellMm = 0.5;
double longest(const glm::dvec3& sides) {
  return std::max({sides.x, sides.y, sides.z});
}

glm::dvec3 vector(const CutList::Vector& from) {
  return {from[0], from[1], from[2]};
}

/// The plane of a lasso. A point of the body at homogeneous (x, y, w) is drawn at (x / w, y / w).
struct Plane {
  explicit Plane(const CutList::Cut& cut)
      : origin(vector(cut.origin)),
        right(vector(cut.right)),
        up(vector(cut.up)),
        forward(glm::cross(up, right)),
        eye_mm(cut.eye_mm) {}

  double depth_mm(const glm::dvec3& at) const { return glm::dot(at - origin, forward); }
  glm::dvec3 homogeneous(const glm::dvec3& at) const {
    const glm::dvec3 from = at - origin;
    return {glm::dot(from, right), glm::dot(from, up),
            eye_mm > 0 ? (glm::dot(from, forward) + eye_mm) / eye_mm : 1};
  }

  glm::dvec3 origin;
  glm::dvec3 right;
  glm::dvec3 up;
  glm::dvec3 forward;
  double eye_mm;
};

/// Where an outline crosses the drawn line through two points of the body: the positions along its longer
/// axis, ascending. By them a point of the line is inside or outside, by the even-odd rule.
class Crossings {
 public:
  /// `from` and `to`: homogeneous. A line that is drawn as a point has the crossings of a horizontal line.
  void find(const glm::dvec3& from, const glm::dvec3& to, std::span<const float> outline) {
    glm::dvec3 line = glm::cross(from, to);
    if (std::abs(line.x) < kPoint && std::abs(line.y) < kPoint) line = {0, from.z, -from.y};
    axis_ = std::abs(line.y) >= std::abs(line.x) ? 0 : 1;
    count_ = 0;
    const std::size_t corners = outline.size() / 2;
    glm::dvec2 before(outline[2 * corners - 2], outline[2 * corners - 1]);
    double side_before = glm::dot(line, glm::dvec3(before, 1));
    for (std::size_t corner = 0; corner < corners; ++corner) {
      const glm::dvec2 next(outline[2 * corner], outline[2 * corner + 1]);
      const double side = glm::dot(line, glm::dvec3(next, 1));
      if ((side < 0) != (side_before < 0)) {
        const glm::dvec2 at = glm::mix(before, next, side_before / (side_before - side));
        places_[count_++] = at[axis_];
      }
      before = next;
      side_before = side;
    }
    std::sort(places_.begin(), places_.begin() + count_);
  }

  bool is_inside(const glm::dvec3& at) const {
    const double place = at[axis_] / at.z;
    std::size_t beyond = 0;
    for (std::size_t i = 0; i < count_; ++i) beyond += places_[i] > place ? 1 : 0;
    return beyond % 2 == 1;
  }

 private:
  static constexpr double kPoint = 1e-9;

  std::array<double, CutList::kMostNumbers / 2> places_;
  std::size_t count_ = 0;
  int axis_ = 0;
};

/// The corners along an axis, from the first at or after a position to the last at or before another.
struct CornerRange {
  std::uint32_t first;
  std::uint32_t end;
};

CornerRange corners_between(double from_mm, double to_mm, double lowest_mm, double cell_mm,
                            std::uint32_t cells) {
  const double first = std::ceil((from_mm - lowest_mm) / cell_mm);
  const double last = std::floor((to_mm - lowest_mm) / cell_mm);
  const double most = cells;
  if (last < 0 || first > most) return {0, 0};
  return {static_cast<std::uint32_t>(std::max(first, 0.0)),
          static_cast<std::uint32_t>(std::min(last, most)) + 1};
}

}  // namespace

double ball_radius_mm(const CutList::Cut& cut, const CutGrid& grid) {
  return std::max<double>(cut.radius_mm, std::numbers::sqrt3 / 2 * grid.cell_mm);
}

CutGrid CutGrid::around(const Box& box) {
  const glm::dvec3 sides = box.highest - box.lowest;
  const double cell_mm = std::max(longest(sides) / kMostCells, kLeastCellMm);
  const auto cells = [cell_mm](double side_mm) {
    return std::clamp(static_cast<std::uint32_t>(std::ceil(side_mm / cell_mm)), 1U, kMostCells);
  };
  return {
      .lowest = box.lowest, .cell_mm = cell_mm, .cells = {cells(sides.x), cells(sides.y), cells(sides.z)}};
}

bool CutMask::update(const CutList& list, const CutGrid& grid) {
  if (list.empty()) {
    const bool changed = !list_.empty();
    list_ = list;
    return changed;
  }
  const bool continues = grid == grid_ && !list_.empty() && list.continues(list_);
  if (continues && list == list_) return false;
  std::size_t done = continues ? list_.cuts().size() : 0;
  if (continues) {
    // The last cut may have got further balls.
    const std::uint32_t made = list_.cuts()[done - 1].count;
    const CutList::Cut& last = list.cuts()[done - 1];
    if (last.count > made) cut_balls(last, list.numbers(last).subspan(made));
  } else {
    grid_ = grid;
    const glm::uvec3 corners = grid_.cells + 1U;
    corners_.assign(std::size_t{corners.x} * corners.y * corners.z, 0);
  }
  for (; done < list.cuts().size(); ++done) apply(list, list.cuts()[done]);
  list_ = list;
  return true;
}

void CutMask::apply(const CutList& list, const CutList::Cut& cut) {
  if (cut.kind == CutList::Kind::kBalls) return cut_balls(cut, list.numbers(cut));
  cut_lasso(cut, list.numbers(cut));
}

void CutMask::cut_lasso(const CutList::Cut& cut, std::span<const float> outline) {
  const Plane plane(cut);
  const bool cuts_inside = cut.kind == CutList::Kind::kInside;
  const glm::dvec3 step(grid_.cell_mm, 0, 0);
  const glm::dvec3 homogeneous_step =
      plane.homogeneous(plane.origin + step) - plane.homogeneous(plane.origin);
  const double depth_step_mm = glm::dot(step, plane.forward);
  Crossings crossings;
  std::uint8_t* corner = corners_.data();
  for (std::uint32_t z = 0; z <= grid_.cells.z; ++z) {
    for (std::uint32_t y = 0; y <= grid_.cells.y; ++y) {
      const glm::dvec3 first = grid_.lowest + grid_.cell_mm * glm::dvec3(0, y, z);
      const glm::dvec3 drawn = plane.homogeneous(first);
      const double depth_mm = plane.depth_mm(first);
      crossings.find(drawn, drawn + homogeneous_step, outline);
      for (std::uint32_t x = 0; x <= grid_.cells.x; ++x, ++corner) {
        const double here_mm = depth_mm + x * depth_step_mm;
        const glm::dvec3 at = drawn + static_cast<double>(x) * homogeneous_step;
        // What lies behind the eye is not drawn.
        if (here_mm < cut.nearest_mm || here_mm > cut.farthest_mm || at.z <= 0) continue;
        if (crossings.is_inside(at) == cuts_inside) *corner = 1;
      }
    }
  }
}

void CutMask::cut_balls(const CutList::Cut& cut, std::span<const float> centres) {
  const double radius_mm = ball_radius_mm(cut, grid_);
  const glm::uvec3 corners = grid_.cells + 1U;
  const auto within = [this](double centre_mm, double half_mm, int axis) {
    return corners_between(centre_mm - half_mm, centre_mm + half_mm, grid_.lowest[axis], grid_.cell_mm,
                           grid_.cells[axis]);
  };
  for (std::size_t number = 0; number < centres.size(); number += 3) {
    const glm::dvec3 centre(centres[number], centres[number + 1], centres[number + 2]);
    const CornerRange layers = within(centre.z, radius_mm, 2);
    const CornerRange rows = within(centre.y, radius_mm, 1);
    for (std::uint32_t z = layers.first; z < layers.end; ++z) {
      for (std::uint32_t y = rows.first; y < rows.end; ++y) {
        const glm::dvec3 row = grid_.lowest + grid_.cell_mm * glm::dvec3(0, y, z) - centre;
        const double squared_mm = radius_mm * radius_mm - row.y * row.y - row.z * row.z;
        if (squared_mm < 0) continue;
        const CornerRange in_row = within(centre.x, std::sqrt(squared_mm), 0);
        const auto first =
            corners_.begin() + static_cast<std::ptrdiff_t>((std::size_t{z} * corners.y + y) * corners.x);
        std::fill(first + in_row.first, first + in_row.end, std::uint8_t{1});
      }
    }
  }
}

void CutMask::write_cells(std::span<std::uint8_t> bytes) const {
  const glm::uvec3 corners = grid_.cells + 1U;
  const std::size_t row = corners.x;
  const std::size_t layer = row * corners.y;
  std::size_t cell = 0;
  for (std::uint32_t z = 0; z < grid_.cells.z; ++z) {
    for (std::uint32_t y = 0; y < grid_.cells.y; ++y) {
      const std::uint8_t* at = corners_.data() + z * layer + y * row;
      for (std::uint32_t x = 0; x < grid_.cells.x; ++x, ++at) {
        bytes[cell++] =
            static_cast<std::uint8_t>(at[0] | at[1] << 1 | at[row] << 2 | at[row + 1] << 3 | at[layer] << 4 |
                                      at[layer + 1] << 5 | at[layer + row] << 6 | at[layer + row + 1] << 7);
      }
    }
  }
}

void set_cuts(shaders::CastParameters& to, const CutList& list, const CutGrid& grid) {
  to.cut_columns = to.cut_rows = to.cut_layers = 0;
  to.cut_lowest = {};
  to.cut_cell = 1;
  if (list.empty()) return;
  to.cut_columns = static_cast<int>(grid.cells.x);
  to.cut_rows = static_cast<int>(grid.cells.y);
  to.cut_layers = static_cast<int>(grid.cells.z);
  to.cut_lowest = grid.lowest;
  to.cut_cell = static_cast<float>(grid.cell_mm);
}

}  // namespace fanlight
