// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/sheet_borders.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <optional>
#include <vector>

namespace fanlight {

namespace {

// Twice what a sheet may rise from one profile to the next: steps farther apart are of different sheets.
constexpr double kApartMm = 6;

class Borders {
 public:
  Borders(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet,
          const BorderLevels& levels)
      : profiles_(profiles),
        steps_(steps),
        levels_(levels),
        apart_(static_cast<int>(std::ceil(kApartMm / profiles.cell_mm()))),
        in_sheet_(profiles.profiles(), false) {
    for (const SheetPoint& point : sheet) in_sheet_[point.profile] = true;
  }

  void add(const SheetPoint& point) {
    const std::uint32_t across = profiles_.across();
    const std::uint32_t column = point.profile % across;
    const bool has_left = column > 0;
    const bool has_right = column + 1 < across;
    const bool has_last = point.profile >= across;
    const bool has_next = point.profile + across < profiles_.profiles();
    const double width_mm = apart_mm(point, has_right ? point.profile + 1 : point.profile - 1);
    const double height_mm = apart_mm(point, has_next ? point.profile + across : point.profile - across);
    borders_.area_mm2 += width_mm * height_mm;
    add(point, has_left, point.profile - 1, height_mm);
    add(point, has_right, point.profile + 1, height_mm);
    add(point, has_last, point.profile - across, width_mm);
    add(point, has_next, point.profile + across, width_mm);
  }

  SheetBorders borders() const { return borders_; }

 private:
  enum class Beside : std::uint8_t { kSame, kBefore, kBehind, kUnknown };

  double apart_mm(const SheetPoint& point, std::uint32_t other) const {
    return glm::distance(profiles_.position(point.profile, point.cell),
                         profiles_.position(other, point.cell));
  }

  void add(const SheetPoint& point, bool has_other, std::uint32_t other, double length_mm) {
    if (has_other && in_sheet_[other]) return;
    borders_.all_mm += length_mm;
    const auto level = has_other ? mean(other, point.cell) : std::nullopt;
    if (!level) {
      borders_.fan_mm += length_mm;
      return;
    }
    const Beside beside = beside_of(point, other, *level);
    if (beside == Beside::kBefore) borders_.before_mm += length_mm;
    if (beside == Beside::kBehind) borders_.behind_mm += length_mm;
  }

  /// How the sheet lies to the steps of another profile, whose level is known at the depth of the point.
  Beside beside_of(const SheetPoint& point, std::uint32_t other, double level) const {
    bool nearer = false;
    bool farther = false;
    for (int cell = steps_.first_peak(other, 0, levels_.least_step); cell >= 0;
         cell = steps_.first_peak(other, cell + 1, levels_.least_step)) {
      if (std::abs(cell - point.cell) <= apart_) return Beside::kSame;  // smaller there than in the sheet
      nearer |= cell < point.cell && !has_step(point.profile, cell);
      farther |= cell > point.cell;
    }
    if (nearer) return Beside::kBehind;
    const auto before = mean(point.profile, point.cell - apart_);
    const bool in_fluid = before && *before <= levels_.fluid && level <= levels_.fluid;
    return farther && in_fluid ? Beside::kBefore : Beside::kUnknown;
  }

  /// Whether a profile has a step near a cell, as where a layer covers the sheet as well. Half of the step is
  /// enough: layers vary.
  bool has_step(std::uint32_t profile, int near_cell) const {
    const int cell = steps_.first_peak(profile, std::max(0, near_cell - apart_), levels_.least_step / 2);
    return cell >= 0 && cell <= near_cell + apart_;
  }

  /// Of kApartMm from a cell on; nullopt: nothing was scanned there.
  std::optional<double> mean(std::uint32_t profile, int from) const {
    double sum = 0;
    int cells = 0;
    const int end = std::min(from + apart_, static_cast<int>(profiles_.cells()));
    for (int cell = std::max(0, from); cell < end; ++cell) {
      const float level = profiles_.level(profile, static_cast<std::uint32_t>(cell));
      if (level < 0) continue;
      sum += level;
      ++cells;
    }
    return cells > 0 ? std::optional(sum / cells) : std::nullopt;
  }

  const VolumeProfiles& profiles_;
  const EchoSteps& steps_;
  BorderLevels levels_;
  int apart_;
  std::vector<bool> in_sheet_;
  SheetBorders borders_;
};

}  // namespace

SheetBorders sheet_borders(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet,
                           const BorderLevels& levels) {
  if (profiles.across() < 2 || profiles.frames() < 2) return {};
  Borders borders(profiles, steps, sheet, levels);
  for (const SheetPoint& point : sheet) borders.add(point);
  return borders.borders();
}

}  // namespace fanlight
