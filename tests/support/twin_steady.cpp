// SPDX-License-Identifier: Apache-2.0
#include "tests/support/twin_steady.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <optional>

#include "renderer/parameters/view_frame.hpp"
#include "tests/support/cpu_twin.hpp"

namespace fanlight::test {

namespace {

constexpr int kMostCells = 64;
// Depths that differ by more are of two surfaces, mm: of pixels, and of cells.
constexpr double kMostApartMm = 2.5;
constexpr double kMostCellsApartMm = 8;
// Of the figures of map_agreement.comp.
constexpr double kLeastMedian = 0x1p-16;

/// Where the pixels of a map lie: to the right, down and in depth, as its view sees them.
struct SteadyFrame {
  PictureView view;
  PictureSize size;
  int left = 0;
  int top = 0;
  int right = 0;   // the last column
  int bottom = 0;  // the last row
  int side = 1;    // of a cell
  int across = 0;  // cells
  int down = 0;

  explicit SteadyFrame(const TwinSteadyMap& map) : view(picture_view(map.scene, map.size)), size(map.size) {
    left = static_cast<int>(view.part.left);
    top = static_cast<int>(view.part.top);
    const int width = static_cast<int>(view.part.width);
    const int height = static_cast<int>(view.part.height);
    right = left + width - 1;
    bottom = top + height - 1;
    side = std::max(4, (std::max(width, height) + kMostCells - 1) / kMostCells);
    across = (width + side - 1) / side;
    down = (height + side - 1) / side;
  }

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * size.width + static_cast<std::size_t>(column);
  }
  bool holds(int column, int row) const {
    return column >= left && row >= top && column <= right && row <= bottom;
  }
  double scale(double depth_mm) const { return view.mm_per_pixel + view.mm_per_pixel_per_mm * depth_mm; }
  glm::dvec2 middle() const { return {view.middle_column, view.middle_row}; }
  glm::dvec3 place(const glm::dvec2& pixel, double depth_mm) const {
    return {(pixel - middle()) * scale(depth_mm), depth_mm};
  }
  glm::dvec2 pixel(const glm::dvec3& place) const {
    return middle() + glm::dvec2(place) / std::max(scale(place.z), 1e-4);
  }
  glm::dvec2 middle_of_cell(int x, int y) const {
    return glm::dvec2(left, top) + (glm::dvec2(x, y) + 0.5) * double(side) - 0.5;
  }
  glm::dvec2 among_cells(const glm::dvec2& pixel) const {
    return (pixel - glm::dvec2(left, top) + 0.5) / double(side) - 0.5;
  }
  int samples() const { return std::min(side, 8); }
  int sample(int cell, int number) const { return cell * side + (2 * number + 1) * side / (2 * samples()); }
};

/// From the frame of one map to that of an earlier one.
struct Motion {
  glm::dmat3 turn{1};
  glm::dvec3 origin{0};
  bool found = false;
  glm::dvec3 at(const glm::dvec3& place) const { return origin + turn * place; }
};

glm::dvec3 as_vector(const std::array<double, 3>& values) {
  return {values[0], values[1], values[2]};
}

glm::dmat3 axes_of(const PictureView& view) {
  return {as_vector(view.right), as_vector(view.down), as_vector(view.forward)};
}

/// Depths of cells; kNoSurface where they do not show one surface.
std::vector<double> cells_of(const SteadyFrame& frame, const std::vector<double>& depth_mm, double step_mm) {
  std::vector<double> cells(std::size_t{kMostCells} * kMostCells, kNoSurface);
  const int samples = frame.samples();
  for (int y = 0; y < frame.down; ++y) {
    for (int x = 0; x < frame.across; ++x) {
      std::vector<double> found;
      for (int down = 0; down < samples; ++down) {
        for (int across = 0; across < samples; ++across) {
          const int column = frame.left + frame.sample(x, across);
          const int row = frame.top + frame.sample(y, down);
          if (!frame.holds(column, row)) continue;
          const double depth = depth_mm[frame.index(column, row)];
          if (depth >= 0) found.push_back(depth);
        }
      }
      const auto mean_of = [&] {
        double sum = 0;
        for (const double each : found) sum += each;
        return sum / static_cast<double>(std::max<std::size_t>(found.size(), 1));
      };
      const double mean = mean_of();
      std::erase_if(found,
                    [&](double each) { return std::abs(each - mean) > std::min(step_mm, kMostApartMm); });
      if (static_cast<double>(found.size()) >= 0.85 * samples * samples)
        cells[static_cast<std::size_t>(y) * kMostCells + x] = mean_of();
    }
  }
  return cells;
}

struct CellPlane {
  double depth_mm = 0;
  glm::dvec3 gradient{};
};

std::optional<CellPlane> plane_at(const SteadyFrame& frame, const std::vector<double>& cells, double step_mm,
                                  const glm::dvec3& place) {
  if (frame.across < 2 || frame.down < 2) return std::nullopt;
  const glm::dvec2 pixel = frame.pixel(place);
  const glm::dvec2 at = frame.among_cells(pixel);
  if (at.x < 0 || at.y < 0 || at.x > frame.across - 1 || at.y > frame.down - 1) return std::nullopt;
  const int x = std::min(static_cast<int>(at.x), frame.across - 2);
  const int y = std::min(static_cast<int>(at.y), frame.down - 2);
  const auto cell = [&](int right, int below) {
    return cells[static_cast<std::size_t>(y + below) * kMostCells + x + right];
  };
  const std::array<double, 4> corners = {cell(0, 0), cell(1, 0), cell(0, 1), cell(1, 1)};
  const auto [least, most] = std::ranges::minmax(corners);
  if (least < 0 || most - least > std::min(2 * step_mm, kMostCellsApartMm)) return std::nullopt;
  const double right = at.x - x;
  const double below = at.y - y;
  const double upper = corners[0] + right * (corners[1] - corners[0]);
  const double lower = corners[2] + right * (corners[3] - corners[2]);
  const glm::dvec2 by_pixel =
      glm::dvec2((1 - below) * (corners[1] - corners[0]) + below * (corners[3] - corners[2]), lower - upper) /
      double(frame.side);
  const double scale = std::max(frame.scale(place.z), 1e-4);
  return CellPlane{.depth_mm = upper + below * (lower - upper),
                   .gradient = {-by_pixel / scale, 1 + glm::dot(by_pixel, pixel - frame.middle()) *
                                                           frame.view.mm_per_pixel_per_mm / scale}};
}

/// Solves a symmetric system by elimination, without pivots.
template <std::size_t kSize>
std::array<double, kSize> solved(std::array<std::array<double, kSize>, kSize> matrix,
                                 std::array<double, kSize> side) {
  for (std::size_t pivot = 0; pivot < kSize; ++pivot) {
    for (std::size_t row = pivot + 1; row < kSize; ++row) {
      const double factor = matrix[row][pivot] / matrix[pivot][pivot];
      for (std::size_t column = pivot; column < kSize; ++column)
        matrix[row][column] -= factor * matrix[pivot][column];
      side[row] -= factor * side[pivot];
    }
  }
  for (std::size_t row = kSize; row-- > 0;) {
    for (std::size_t column = row + 1; column < kSize; ++column)
      side[row] -= matrix[row][column] * side[column];
    side[row] /= matrix[row][row];
  }
  return side;
}

glm::dmat3 turn_by(const glm::dvec3& turn) {
  const double angle = glm::length(turn);
  const glm::dvec3 axis = turn / std::max(angle, 1e-12);
  glm::dmat3 matrix;
  for (int column = 0; column < 3; ++column) {
    glm::dvec3 unit(0);
    unit[column] = 1;
    matrix[column] = std::cos(angle) * unit + std::sin(angle) * glm::cross(axis, unit) +
                     (1 - std::cos(angle)) * glm::dot(axis, unit) * axis;
  }
  return matrix;
}

Motion motion_between(const SteadyFrame& now, const std::vector<double>& now_cells,
                      const SteadyFrame& earlier, const std::vector<double>& earlier_cells,
                      const Scene& scene) {
  constexpr double kLeverMm = 30;
  const glm::dmat3 to_earlier = glm::transpose(axes_of(earlier.view));
  Motion motion{.turn = to_earlier * axes_of(now.view),
                .origin = to_earlier * (as_vector(now.view.origin_mm) - as_vector(earlier.view.origin_mm))};
  const glm::dvec3 pivot = motion.at({0, 0, scene.camera.distance_mm});
  glm::dvec3 turned(0);
  glm::dvec3 moved(0);
  double weights = 0;
  double both = 0;
  for (const double limit_mm : {4.0, 3.0, 2.0, 1.2, 0.8, 0.8}) {
    std::array<std::array<double, 6>, 6> matrix{};
    std::array<double, 6> side{};
    weights = both = 0;
    for (int y = 0; y < now.down; ++y) {
      for (int x = 0; x < now.across; ++x) {
        const double depth_mm = now_cells[static_cast<std::size_t>(y) * kMostCells + x];
        if (depth_mm < 0) continue;
        const glm::dvec3 place = motion.at(now.place(now.middle_of_cell(x, y), depth_mm));
        const auto plane = plane_at(earlier, earlier_cells, scene.filter.step_mm, place);
        if (!plane) continue;
        ++both;
        const double steepness = glm::length(plane->gradient);
        const double away = (place.z - plane->depth_mm) / steepness;
        const glm::dvec3 normal = plane->gradient / steepness;
        const glm::dvec3 lever = glm::cross(place - pivot, normal) / kLeverMm;
        const std::array<double, 6> row = {lever.x, lever.y, lever.z, normal.x, normal.y, normal.z};
        const double share = std::clamp(away / limit_mm, -1.0, 1.0);
        const double weight = (1 - share * share) * (1 - share * share);
        weights += weight;
        for (std::size_t first = 0; first < 6; ++first) {
          for (std::size_t second = 0; second < 6; ++second)
            matrix[first][second] += weight * row[first] * row[second];
          side[first] -= weight * row[first] * away;
        }
      }
    }
    double trace = 0;
    for (std::size_t each = 0; each < 6; ++each) trace += matrix[each][each];
    for (std::size_t each = 0; each < 6; ++each) matrix[each][each] += 2e-3 * trace / 6 + 1e-6;
    const auto solution = solved(matrix, side);
    const glm::dvec3 turn = glm::dvec3(solution[0], solution[1], solution[2]) / kLeverMm;
    const glm::dvec3 shift(solution[3], solution[4], solution[5]);
    const glm::dmat3 matrix_of_turn = turn_by(turn);
    motion.turn = matrix_of_turn * motion.turn;
    motion.origin = pivot + matrix_of_turn * (motion.origin - pivot) + shift;
    turned += turn;
    moved += shift;
  }
  motion.found =
      weights >= 12 && weights >= 0.3 * both && glm::length(moved) <= 8 && glm::length(turned) <= 0.15;
  return motion;
}

/// Depth and volumes of the earlier map between its pixels.
std::optional<glm::dvec2> earlier_at(const SteadyFrame& frame, const TwinSteadyMap& map,
                                     const glm::dvec2& pixel) {
  if (pixel.x < frame.left - 0.5 || pixel.y < frame.top - 0.5 || pixel.x > frame.right + 0.5 ||
      pixel.y > frame.bottom + 0.5)
    return std::nullopt;
  const int x = std::clamp(static_cast<int>(std::floor(pixel.x)), frame.left, frame.right);
  const int y = std::clamp(static_cast<int>(std::floor(pixel.y)), frame.top, frame.bottom);
  const double right = std::clamp(pixel.x - x, 0.0, 1.0);
  const double below = std::clamp(pixel.y - y, 0.0, 1.0);
  const auto at = [&](int across, int down) {
    const std::size_t index =
        frame.index(std::min(x + across, frame.right), std::min(y + down, frame.bottom));
    return glm::dvec2(map.depth_mm[index], map.volumes[index]);
  };
  const std::array<glm::dvec2, 4> corners = {at(0, 0), at(1, 0), at(0, 1), at(1, 1)};
  const auto [least, most] =
      std::ranges::minmax(std::array{corners[0].x, corners[1].x, corners[2].x, corners[3].x});
  glm::dvec2 found = at(right < 0.5 ? 0 : 1, below < 0.5 ? 0 : 1);
  if (least >= 0 && most - least <= std::min(map.scene.filter.step_mm, kMostApartMm)) {
    const glm::dvec2 upper = corners[0] + right * (corners[1] - corners[0]);
    const glm::dvec2 lower = corners[2] + right * (corners[3] - corners[2]);
    found = upper + below * (lower - upper);
  }
  return found.x >= 0 ? std::optional(found) : std::nullopt;
}

/// What is known of a cell of the map.
struct CellAgreement {
  double difference_mm = 0;
  double weight = 0;
  glm::dvec2 slope{0};
  double stretch = 1;
  double doubt = 1e3;
};

class CellAgreements {
 public:
  explicit CellAgreements(const SteadyFrame& frame)
      : frame_(frame), cells_(std::size_t{kMostCells} * kMostCells) {}
  CellAgreement& at(int x, int y) { return cells_[static_cast<std::size_t>(y) * kMostCells + x]; }
  const CellAgreement& at(int x, int y) const { return cells_[static_cast<std::size_t>(y) * kMostCells + x]; }

  void find_doubts() {
    std::vector<glm::dvec3> figures;
    std::vector<CellAgreement*> known;
    for (int y = 0; y < frame_.down; ++y) {
      for (int x = 0; x < frame_.across; ++x) {
        if (at(x, y).weight == 0) continue;
        known.push_back(&at(x, y));
        figures.push_back(figures_at(x, y));
      }
    }
    if (known.empty()) return;
    const double roughness = median(figures, 2) / (0.455 * 1.25);
    const bool is_rough = roughness > 2 * kLeastMedian;
    const double squares = std::min(median(figures, 0), is_rough ? 3.2 * roughness : HUGE_VAL);
    const double explained = std::min(median(figures, 1), is_rough ? 5 * roughness : HUGE_VAL);
    for (std::size_t cell = 0; cell < known.size(); ++cell) {
      known[cell]->doubt =
          std::max(figures[cell].x / squares - 8, 0.0) + std::max(figures[cell].y / explained - 6, 0.0);
    }
  }

  /// Doubt and stretch.
  glm::dvec2 between(const glm::dvec2& pixel) const {
    const glm::dvec2 at_cells =
        glm::clamp(frame_.among_cells(pixel), glm::dvec2(0), glm::dvec2(frame_.across - 1, frame_.down - 1));
    const int x = static_cast<int>(at_cells.x);
    const int y = static_cast<int>(at_cells.y);
    const auto of = [&](int right, int below) {
      const CellAgreement& cell =
          at(std::min(x + right, frame_.across - 1), std::min(y + below, frame_.down - 1));
      return glm::dvec2(cell.doubt, cell.stretch);
    };
    const glm::dvec2 upper = glm::mix(of(0, 0), of(1, 0), at_cells.x - x);
    const glm::dvec2 lower = glm::mix(of(0, 1), of(1, 1), at_cells.x - x);
    return glm::mix(upper, lower, at_cells.y - y);
  }

 private:
  /// The middle of a range of logarithms that is halved 16 times, and not below 2^-16.
  static double median(const std::vector<glm::dvec3>& figures, int which) {
    std::vector<double> values;
    for (const glm::dvec3& each : figures) {
      if (each[which] >= 0) values.push_back(each[which]);
    }
    if (values.empty()) return kLeastMedian;
    std::ranges::sort(values);
    return std::max(values[values.size() / 2], kLeastMedian);
  }

  double roughness_at(int x, int y) const {
    if (x < 2 || y < 2 || x + 2 >= frame_.across || y + 2 >= frame_.down) return -1;
    double mean = 0;
    for (const CellAgreement* const cell : {&at(x - 2, y), &at(x + 2, y), &at(x, y - 2), &at(x, y + 2)}) {
      if (cell->weight == 0) return -1;
      mean += cell->difference_mm / 4;
    }
    const double away = at(x, y).difference_mm - mean;
    return at(x, y).weight * away * away;
  }

  glm::dvec3 figures_at(int x, int y) const {
    double squares = 0;
    double near_weights = 0;
    std::array<std::array<double, 3>, 3> matrix{};
    std::array<double, 3> side{};
    for (int row = std::max(y - 3, 0); row <= std::min(y + 3, frame_.down - 1); ++row) {
      for (int column = std::max(x - 3, 0); column <= std::min(x + 3, frame_.across - 1); ++column) {
        const CellAgreement& cell = at(column, row);
        if (std::abs(row - y) <= 1 && std::abs(column - x) <= 1) {
          squares += cell.weight * cell.difference_mm * cell.difference_mm;
          near_weights += cell.weight;
        }
        const std::array<double, 3> by = {cell.slope.x, cell.slope.y, 1};
        for (std::size_t first = 0; first < 3; ++first) {
          for (std::size_t second = 0; second < 3; ++second)
            matrix[first][second] += cell.weight * by[first] * by[second];
          side[first] += cell.weight * cell.difference_mm * by[first];
        }
      }
    }
    const double damping = 0.01 * matrix[2][2];
    for (std::size_t each = 0; each < 3; ++each) matrix[each][each] += damping;
    const auto shift = solved(matrix, side);
    return {squares / near_weights, side[0] * shift[0] + side[1] * shift[1] + side[2] * shift[2],
            roughness_at(x, y)};
  }

  const SteadyFrame& frame_;
  std::vector<CellAgreement> cells_;
};

}  // namespace

TwinSteadyMap twin_single(const Scene& scene, PictureSize size, std::vector<double> depth_mm) {
  TwinSteadyMap map{.scene = scene, .size = size, .depth_mm = std::move(depth_mm), .volumes = {}};
  for (const double depth : map.depth_mm) map.volumes.push_back(depth >= 0 ? 1 : 0);
  return map;
}

TwinSteadyMap twin_seam(const TwinSteadyMap& now, const TwinSteadyMap& before, const FanGeometry& geometry,
                        const std::vector<TwinNewFrame>& frames, double frame_step_rad) {
  const SteadyFrame frame(now);
  const SteadyFrame frame_before(before);
  const glm::dmat3 to_before = glm::transpose(axes_of(frame_before.view));
  const glm::dvec3 apart = as_vector(frame.view.origin_mm) - as_vector(frame_before.view.origin_mm);
  const Motion still{.turn = to_before * axes_of(frame.view), .origin = to_before * apart};
  TwinSteadyMap result = now;
  if (frame.across == 0 || frame_before.across == 0) return result;
  for (int row = frame.top; row <= frame.bottom; ++row) {
    for (int column = frame.left; column <= frame.right; ++column) {
      const std::size_t pixel = frame.index(column, row);
      const double here = now.depth_mm[pixel];
      if (here < 0) continue;
      const glm::dvec3 local = frame.place({column, row}, here);
      const auto component = [&](std::size_t axis) {
        return frame.view.origin_mm[axis] + local.x * frame.view.right[axis] +
               local.y * frame.view.down[axis] + local.z * frame.view.forward[axis];
      };
      const double angle_rad = geometry.fan_coordinate(component(1), component(2)).angle_rad;
      double share = 0;
      double share_before = 0;
      for (const TwinNewFrame& each : frames) {
        const double near = std::max(0.0, 1 - std::abs(angle_rad - each.angle_rad) / frame_step_rad);
        share += near * each.share;
        share_before += near * each.share_before;
      }
      if (share <= 0) continue;
      const glm::dvec3 place = still.at(local);
      const auto there = earlier_at(frame_before, before, frame_before.pixel(place));
      if (!there) continue;
      const double away = place.z - there->x;
      const double ratio = away / std::min(now.scene.filter.step_mm, 5.0);
      result.depth_mm[pixel] =
          here - std::min(share / share_before, 1.0) * std::max(1 - ratio * ratio, 0.0) * away;
    }
  }
  return result;
}

TwinSteadyMap twin_steady(const TwinSteadyMap& now, const TwinSteadyMap& earlier) {
  const SteadyFrame frame(now);
  const SteadyFrame before(earlier);
  TwinSteadyMap result = now;
  const Scene::Filter& filter = now.scene.filter;
  if (frame.across == 0 || before.across == 0 || filter.steady == 0) return result;
  const auto now_cells = cells_of(frame, now.depth_mm, filter.step_mm);
  const auto earlier_cells = cells_of(before, earlier.depth_mm, filter.step_mm);
  const Motion motion = motion_between(frame, now_cells, before, earlier_cells, now.scene);
  if (!motion.found) return result;

  const double most_mm = std::min(filter.step_mm, kMostApartMm);
  CellAgreements agreements(frame);
  for (int y = 0; y < frame.down; ++y) {
    for (int x = 0; x < frame.across; ++x) {
      CellAgreement& cell = agreements.at(x, y);
      double shown = 0;
      double count = 0;
      double sum = 0;
      for (int down = 0; down < frame.samples(); ++down) {
        for (int across = 0; across < frame.samples(); ++across) {
          const int column = frame.left + frame.sample(x, across);
          const int row = frame.top + frame.sample(y, down);
          if (!frame.holds(column, row)) continue;
          const double here = now.depth_mm[frame.index(column, row)];
          if (here < 0) continue;
          const glm::dvec3 place = motion.at(frame.place({column, row}, here));
          const auto there = earlier_at(before, earlier, before.pixel(place));
          if (!there) continue;
          ++shown;
          if (std::abs(place.z - there->x) > most_mm) continue;
          ++count;
          sum += place.z - there->x;
        }
      }
      const glm::dvec2 middle = frame.middle_of_cell(x, y);
      const double mean = now_cells[static_cast<std::size_t>(y) * kMostCells + x];
      double stretch = 1;
      double weight = 0.1;
      if (mean >= 0) {
        const auto plane =
            plane_at(before, earlier_cells, filter.step_mm, motion.at(frame.place(middle, mean)));
        if (plane) {
          const glm::dvec3 ray((middle - frame.middle()) * frame.view.mm_per_pixel_per_mm, 1);
          const double along = glm::dot(plane->gradient, motion.turn * ray);
          stretch = along >= 0.3 ? 1 / along : 0;
          cell.slope = -glm::dvec2(plane->gradient) / plane->gradient.z;
          weight = 1 / (1 + glm::dot(cell.slope, cell.slope));
        }
      }
      const bool compares = count >= 4 && 2 * count >= shown && stretch > 0;
      cell.difference_mm = sum / std::max(count, 1.0);
      cell.weight = compares ? weight : 0;
      cell.stretch = stretch > 0 ? stretch : 1;
    }
  }
  agreements.find_doubts();

  for (int row = frame.top; row <= frame.bottom; ++row) {
    for (int column = frame.left; column <= frame.right; ++column) {
      const std::size_t pixel = frame.index(column, row);
      const double here = now.depth_mm[pixel];
      if (here < 0) continue;
      const glm::dvec3 place = motion.at(frame.place({column, row}, here));
      const auto there = earlier_at(before, earlier, before.pixel(place));
      if (!there || std::abs(place.z - there->x) > most_mm || there->y < 1) continue;
      const glm::dvec2 agreement = agreements.between({column, row});
      const double volumes = std::min(1 + 1 / (1 / there->y + agreement.x), 1 / (1 - filter.steady));
      result.depth_mm[pixel] = here - (1 - 1 / volumes) * agreement.y * (place.z - there->x);
      result.volumes[pixel] = volumes;
    }
  }
  return result;
}

}  // namespace fanlight::test
