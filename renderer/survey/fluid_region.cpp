// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/fluid_region.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "proto/model/echo_levels.hpp"
#include "renderer/survey/cell_sets.hpp"
#include "renderer/survey/echo_amplitude.hpp"
#include "renderer/survey/echo_survey.hpp"
#include "renderer/survey/wall_levels.hpp"

namespace fanlight {

namespace {

// The first grid, of the whole reach, finds the region; a second one, as fine as the region is small,
// measures.
constexpr double kCoarseMm = 0.8;
constexpr double kFinestMm = 0.15;
constexpr double kCellsAcrossRegion = 88;
constexpr double kAroundMm = 7;  // of the second grid, around the region: where the wall's level is taken
constexpr int kFluidSmoothings = 2;

// Below the wall. At a border of scatterers without order, whose powers add, a beam leaves half of the power,
// 3 dB; of amplitudes half, 6 dB. The deviation stands for the way between.
constexpr double kBorderDb = 4.4;
constexpr double kDeviationDb = 1.5;
constexpr double kFirstBorderDb = 12;  // what is dark without doubt
constexpr double kFirstWallMm = 25;    // around the seed
constexpr double kFirstWallShare = 0.8;
constexpr double kLeastContrast = 4;  // of amplitudes, that tells the wall from fluid: 12 dB

constexpr double kGrowthMm = 3;  // in a round
constexpr double kNeckMm = 1.5;  // half of the width of an opening that is closed
constexpr int kRounds = 4;
constexpr double kMostLastGrowthMm = 0.5;  // more: no border holds
constexpr int kPoints = 4;                 // of a cell that the border crosses, in each direction

/// The region of cells that are darker than `border` around the seed's, among those of `may`; empty where the
/// seed's is not dark. A region that is connected through a neck narrower than `neck` cells to each side ends
/// there.
Cells grown(const EchoGrid& grid, std::size_t seed, double border, std::uint32_t neck, const Cells& may) {
  const CellBox& box = grid.box;
  Cells dark(may);
  for (std::size_t index = 0; index < dark.size(); ++index)
    if (!(grid.levels[index] < border)) dark[index] = 0;
  if (dark[seed] == 0) return {};
  const Cells steps = steps_within(box, dark, neck + 1);
  // In a cavity that is narrower than such a neck itself, all that is connected.
  Cells core(dark.size());
  const std::uint8_t least = std::min<std::uint8_t>(steps[seed], static_cast<std::uint8_t>(neck + 1));
  for (std::size_t index = 0; index < dark.size(); ++index) core[index] = steps[index] >= least ? 1 : 0;
  core = spread(box, {seed}, core, dark.size());
  return spread(box, indices_of(core), dark, least > 0 ? least - 1U : 0U);
}

/// The level that a share of the values lies below; 0 where there are none.
double quantile(std::vector<float>& values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

/// The amplitude of tissue before a region is known: the brighter part of what lies around the seed.
double first_wall_amplitude(const EchoGrid& grid, const Cell& seed) {
  const auto reach = static_cast<std::uint32_t>(kFirstWallMm / grid.box.step_mm);
  std::vector<float> amplitudes;
  const auto from = [&](std::uint32_t at) { return at > reach ? at - reach : 0; };
  const auto to = [&](std::uint32_t at, std::size_t axis) {
    return std::min(at + reach + 1, grid.box.size[axis]);
  };
  for (std::uint32_t k = from(seed.k); k < to(seed.k, 2); ++k) {
    for (std::uint32_t j = from(seed.j); j < to(seed.j, 1); ++j) {
      for (std::uint32_t i = from(seed.i); i < to(seed.i, 0); ++i) {
        const std::size_t index = grid.box.index(i, j, k);
        if (grid.scanned[index] != 0) amplitudes.push_back(grid.levels[index]);
      }
    }
  }
  return quantile(amplitudes, kFirstWallShare);
}

double mean_amplitude(const EchoGrid& grid, const Cells& region) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t index = 0; index < region.size(); ++index) {
    if (region[index] == 0) continue;
    sum += grid.levels[index];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

/// How far the level of a cell lies below the border's, in the unit of the grid.
struct Depths {
  const EchoGrid& grid;
  const Cells& region;
  double border = 0;

  /// Positive inside. What is as dark but not in the region lies outside.
  double at(std::size_t index) const {
    const double below = border - grid.levels[index];
    constexpr double kLeast = 1e-6;
    return region[index] != 0 ? std::max(below, kLeast) : std::min(below, -kLeast);
  }
};

/// The share of a cube between eight centres that lies inside, by kPoints in each direction.
double share_inside(const std::array<double, 8>& corners) {
  const auto middle = [](int part) { return (part + 0.5) / kPoints; };
  int points = 0;
  for (int z = 0; z < kPoints; ++z) {
    std::array<double, 4> slice{};
    for (std::size_t corner = 0; corner < 4; ++corner)
      slice[corner] = std::lerp(corners[corner], corners[corner + 4], middle(z));
    for (int y = 0; y < kPoints; ++y) {
      const double left = std::lerp(slice[0], slice[2], middle(y));
      const double right = std::lerp(slice[1], slice[3], middle(y));
      for (int x = 0; x < kPoints; ++x) points += std::lerp(left, right, middle(x)) > 0 ? 1 : 0;
    }
  }
  return points / double{kPoints * kPoints * kPoints};
}

/// The volume of what is darker than the border, in cells.
double volume_cells(const EchoGrid& grid, const Cells& region, double border) {
  const CellBox& box = grid.box;
  const Depths depths{grid, region, border};
  double cells = 0;
  for (std::uint32_t k = 0; k + 1 < box.size[2]; ++k) {
    for (std::uint32_t j = 0; j + 1 < box.size[1]; ++j) {
      for (std::uint32_t i = 0; i + 1 < box.size[0]; ++i) {
        std::array<std::size_t, 8> corners{};
        for (std::uint32_t corner = 0; corner < 8; ++corner)
          corners[corner] = box.index(i + (corner & 1U), j + (corner >> 1U & 1U), k + (corner >> 2U));
        const auto inside =
            std::ranges::count_if(corners, [&](std::size_t index) { return region[index] != 0; });
        if (inside == 0) continue;
        std::array<double, 8> levels{};
        std::ranges::transform(corners, levels.begin(), [&](std::size_t index) { return depths.at(index); });
        cells += inside == 8 ? 1 : share_inside(levels);
      }
    }
  }
  return cells;
}

struct CellExtent {
  std::array<std::uint32_t, 3> first{~0U, ~0U, ~0U};
  std::array<std::uint32_t, 3> last{};
  bool touches_side = false;  // of the grid
  bool touches_unscanned = false;
  std::size_t cells = 0;
  std::size_t border_cells = 0;  // with a neighbour that is not in the region
};

CellExtent extent_of(const EchoGrid& grid, const Cells& region) {
  CellExtent extent;
  for (std::size_t index = 0; index < region.size(); ++index) {
    if (region[index] == 0) continue;
    const Cell at = cell_of(grid.box, index);
    const std::array<std::uint32_t, 3> place = {at.i, at.j, at.k};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent.first[axis] = std::min(extent.first[axis], place[axis]);
      extent.last[axis] = std::max(extent.last[axis], place[axis]);
    }
    extent.touches_side |= !grid.box.is_inner(at.i, at.j, at.k);
    bool is_border = false;
    each_neighbour(grid.box, index, [&](std::size_t other) {
      extent.touches_unscanned |= grid.scanned[other] == 0;
      is_border |= region[other] == 0;
    });
    ++extent.cells;
    extent.border_cells += is_border ? 1 : 0;
  }
  return extent;
}

Error not_closed(const CellExtent& extent) {
  if (extent.touches_unscanned) {
    return {
        ErrorCode::kInvalidArgument,
        "the fluid is open: it reaches the edge of the scan, expected a region that is closed all around"};
  }
  return {ErrorCode::kInvalidArgument,
          fmt::format("the fluid reaches farther than {} mm from this point, expected a smaller region",
                      kMostFluidReachMm)};
}

Error not_fluid() {
  return {ErrorCode::kInvalidArgument, "this point is not in fluid, expected a darker place"};
}

/// A region on a grid.
struct Found {
  EchoGrid grid;  // amplitudes, as shares of the wall's
  Cells region;
  double border = 0;  // in the grid
  double fluid = 0;   // mean amplitude
  double wall = 0;
};

std::uint32_t neck_cells(const CellBox& box) {
  return static_cast<std::uint32_t>(std::lround(kNeckMm / box.step_mm));
}

/// The region in a box. The level of its border follows from the tissue around it, which follows from the
/// region: so it is grown several times. Errors: the seed is not in fluid; there is no border that holds.
Result<Found> found_in(const Volume& volume, const CellBox& box, const FluidSeed& seed,
                       const EchoLevels& levels, const std::stop_token& stop) {
  const EchoAmplitude amplitudes(levels);
  Found found{.grid = sampled(volume, box)};
  amplitudes.replace(found.grid);
  for (int count = 0; count < kFluidSmoothings; ++count) smooth(found.grid);
  const auto cell = [&](double at_mm, double first_mm) {
    return static_cast<std::uint32_t>(std::lround((at_mm - first_mm) / box.step_mm));
  };
  const Cell at{.i = cell(seed.at.x_mm, box.first.x_mm),
                .j = cell(seed.at.y_mm, box.first.y_mm),
                .k = cell(seed.at.z_mm, box.first.z_mm)};
  const std::size_t index = box.index(at.i, at.j, at.k);
  if (found.grid.scanned[index] == 0)
    return Error{ErrorCode::kInvalidArgument, "nothing was scanned at this point, expected one in the fluid"};
  found.wall = first_wall_amplitude(found.grid, at);
  // In a large region most of what lies around is fluid.
  const bool is_all_fluid = found.wall < kLeastContrast * found.grid.levels[index];
  if (is_all_fluid && levels.known) found.wall = amplitudes.of(levels.tissue);
  // First what is dark without doubt.
  found.border = found.wall * amplitude_ratio(std::min(seed.border_db, 0.0) - kFirstBorderDb);
  Cells may(found.grid.levels.size(), 1);
  double cells_before = 0;
  for (int round = 0; round < kRounds; ++round) {
    found.region = grown(found.grid, index, found.border, neck_cells(box), may);
    if (found.region.empty()) return not_fluid();
    if (stop.stop_requested()) return Error{ErrorCode::kStopped, "the measurement was stopped"};
    // Already what is dark without doubt may be open.
    const CellExtent extent = extent_of(found.grid, found.region);
    if (extent.touches_side || extent.touches_unscanned) return not_closed(extent);
    const bool is_last = round + 1 == kRounds;
    const double growth_mm = (static_cast<double>(extent.cells) - cells_before) /
                             static_cast<double>(extent.border_cells) * box.step_mm;
    if (is_last && growth_mm > kMostLastGrowthMm)
      return Error{ErrorCode::kInvalidArgument,
                   "the fluid has no clear border, expected tissue all around it"};
    if (is_last) break;
    cells_before = static_cast<double>(extent.cells);
    const double fluid = mean_amplitude(found.grid, found.region);
    const double wall = flatten_wall(found.grid, found.region);
    if (wall <= fluid) return not_fluid();
    found.wall = round == 0 ? wall : found.wall * wall;
    found.border = amplitude_ratio(seed.border_db - kBorderDb);
    // Farther away the tissue may be as dark as this border: it is not known there.
    const std::vector<std::size_t> near = indices_of(found.region);
    may = spread(box, near, Cells(may.size(), 1), static_cast<std::size_t>(kGrowthMm / box.step_mm));
  }
  found.fluid = found.wall * mean_amplitude(found.grid, found.region);
  return found;
}

/// The region's volume with a border of another level, mm3. It moves by kBorderMoveMm at most.
double volume_mm3(const Found& found, double border_db) {
  constexpr double kBorderMoveMm = 3;
  const CellBox& box = found.grid.box;
  const double border = found.border * amplitude_ratio(border_db);
  Cells dark(found.region.size());
  for (std::size_t index = 0; index < dark.size(); ++index)
    dark[index] = found.grid.levels[index] < border ? 1 : 0;
  std::vector<std::size_t> from;
  for (std::size_t index = 0; index < dark.size(); ++index)
    if (found.region[index] != 0 && dark[index] != 0) from.push_back(index);
  const auto steps = static_cast<std::size_t>(kBorderMoveMm / box.step_mm);
  const Cells region = spread(box, from, dark, border_db > 0 ? steps : 0);
  return box.step_mm * box.step_mm * box.step_mm * volume_cells(found.grid, region, border);
}

/// The part of the grid around the region, coarse enough for drawing.
void draw_border(const Found& found, const CellExtent& extent, FluidRegion& to) {
  const CellBox& from = found.grid.box;
  // As much around the region as a step of the drawn grid.
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    longest = std::max(longest, 1.0 + extent.last[axis] - extent.first[axis]);
  constexpr double kMostSteps = FluidRegion::kMostCellsASide - 1;
  const double stride = std::max(1.0, longest / (kMostSteps - 4));
  const auto margin = static_cast<std::uint32_t>(std::ceil(stride)) + 1;
  std::array<double, 3> first{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    first[axis] = extent.first[axis] > margin ? extent.first[axis] - margin : 0;
    const double cells = std::min(extent.last[axis] + margin, from.size[axis] - 1) - first[axis];
    to.box.size[axis] =
        std::min(static_cast<std::uint32_t>(std::ceil(cells / stride)) + 1, FluidRegion::kMostCellsASide);
  }
  to.box.step_mm = stride * from.step_mm;
  to.box.first = {from.first.x_mm + first[0] * from.step_mm, from.first.y_mm + first[1] * from.step_mm,
                  from.first.z_mm + first[2] * from.step_mm};
  EchoGrid depths{.box = from, .levels = std::vector<float>(from.cells()), .scanned = {}};
  const Depths below{found.grid, found.region, found.border};
  // Farther out nothing is drawn, however dark it is.
  constexpr std::size_t kNearSteps = 3;
  const Cells near = spread(from, indices_of(found.region), Cells(from.cells(), 1), kNearSteps);
  for (std::size_t index = 0; index < from.cells(); ++index)
    depths.levels[index] = static_cast<float>(near[index] != 0 ? below.at(index) : -found.border);
  // The whole way from fluid to border is as much as the scale has.
  const double per_level = 127 / found.border;
  to.depths.resize(to.box.cells());
  std::size_t cell = 0;
  for (std::uint32_t k = 0; k < to.box.size[2]; ++k) {
    for (std::uint32_t j = 0; j < to.box.size[1]; ++j) {
      for (std::uint32_t i = 0; i < to.box.size[0]; ++i, ++cell) {
        const auto place = [&](std::size_t axis, std::uint32_t step) {
          return std::min(first[axis] + step * stride, from.size[axis] - 1.0);
        };
        const double level = depths.level(place(0, i), place(1, j), place(2, k));
        to.depths[cell] = static_cast<std::uint8_t>(
            std::floor(std::clamp(FluidRegion::kBorder + level * per_level, 0.0, 255.0)));
      }
    }
  }
}

/// The box of a finer grid around a region.
CellBox box_of(const CellBox& from, const CellExtent& extent, double step_mm) {
  const auto first = [&](double origin_mm, std::size_t axis) {
    return origin_mm + extent.first[axis] * from.step_mm - kAroundMm;
  };
  CellBox box{.first = {first(from.first.x_mm, 0), first(from.first.y_mm, 1), first(from.first.z_mm, 2)},
              .step_mm = step_mm};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double side_mm = (extent.last[axis] - extent.first[axis]) * from.step_mm + 2 * kAroundMm;
    box.size[axis] = static_cast<std::uint32_t>(std::ceil(side_mm / step_mm)) + 1;
  }
  return box;
}

}  // namespace

Result<FluidRegion> grown_fluid(const Volume& volume, const FluidSeed& seed, const std::stop_token& stop) {
  if (volume.stamp().frames < 2)
    return Error{ErrorCode::kUnavailable, "this volume has one frame, expected two or more"};
  const EchoLevels levels = measured_levels(volume);
  const EchoAmplitude amplitudes(levels);
  auto found = found_in(volume, box_around(seed.at, kMostFluidReachMm, kCoarseMm), seed, levels, stop);
  if (!found) return found.error();
  CellExtent extent = extent_of(found->grid, found->region);
  double longest_mm = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    longest_mm = std::max(longest_mm, (extent.last[axis] - extent.first[axis] + 1) * kCoarseMm);
  const double step_mm = std::max(kFinestMm, longest_mm / kCellsAcrossRegion);
  if (step_mm < kCoarseMm) {
    found = found_in(volume, box_of(found->grid.box, extent, step_mm), seed, levels, stop);
    if (!found) return found.error();
    extent = extent_of(found->grid, found->region);
  }
  if (stop.stop_requested()) return Error{ErrorCode::kStopped, "the measurement was stopped"};
  FluidRegion region{
      .volume_mm3 = volume_mm3(*found, 0),
      .deviation_mm3 = (volume_mm3(*found, kDeviationDb) - volume_mm3(*found, -kDeviationDb)) / 2,
      .fluid_level = amplitudes.grey(found->fluid),
      .border_level = amplitudes.grey(found->border * found->wall),
      .wall_level = amplitudes.grey(found->wall)};
  draw_border(*found, extent, region);
  return region;
}

}  // namespace fanlight
