// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/sheet_borders.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace fanlight {

namespace {

// Steps of neighbouring profiles that are farther apart are of different sheets.
constexpr double kApartMm = 6;

class Borders {
 public:
  Borders(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet, float least_step)
      : profiles_(profiles),
        steps_(steps),
        least_step_(least_step),
        apart_(static_cast<int>(std::ceil(kApartMm / profiles.cell_mm()))),
        in_sheet_(profiles.profiles(), false) {
    for (const SheetPoint& point : sheet) in_sheet_[point.profile] = true;
  }

  void add(const SheetPoint& point) {
    const std::uint32_t across = profiles_.across();
    const std::uint32_t column = point.profile % across;
    if (column > 0) add(point, point.profile - 1);
    if (column + 1 < across) add(point, point.profile + 1);
    if (point.profile >= across) add(point, point.profile - across);
    if (point.profile + across < profiles_.profiles()) add(point, point.profile + across);
  }

  SheetBorders counted() const { return counted_; }

 private:
  void add(const SheetPoint& point, std::uint32_t other) {
    if (in_sheet_[other]) return;
    ++counted_.all;
    bool farther = false;
    for (int cell = steps_.first_peak(other, 0, least_step_); cell >= 0;
         cell = steps_.first_peak(other, cell + 1, least_step_)) {
      if (std::abs(cell - point.cell) <= apart_) return;  // the same, but smaller there
      farther |= cell > point.cell;
      if (cell < point.cell && !has_step(point.profile, cell)) {
        ++counted_.behind;
        return;
      }
    }
    counted_.before += farther && is_dark(other, point) ? 1 : 0;
  }

  /// Whether a profile is as dark behind the depth of a point as before the point.
  bool is_dark(std::uint32_t other, const SheetPoint& point) const {
    const double before = mean(point.profile, point.cell - apart_);
    const double behind = mean(point.profile, point.cell);
    return mean(other, point.cell) < (before + behind) / 2;
  }

  /// Of as many cells as steps may be apart.
  double mean(std::uint32_t profile, int from) const {
    double sum = 0;
    int cells = 0;
    for (int cell = std::max(0, from); cell < std::min(from + apart_, static_cast<int>(profiles_.cells()));
         ++cell) {
      const float level = profiles_.level(profile, static_cast<std::uint32_t>(cell));
      if (level < 0) continue;
      sum += level;
      ++cells;
    }
    return cells > 0 ? sum / cells : 0;
  }

  /// Whether a profile has a step near a cell, as layers do that go on before the sheet.
  bool has_step(std::uint32_t profile, int near_cell) const {
    const int cell = steps_.first_peak(profile, std::max(0, near_cell - apart_), least_step_ / 2);
    return cell >= 0 && cell <= near_cell + apart_;
  }

  const VolumeProfiles& profiles_;
  const EchoSteps& steps_;
  float least_step_;
  int apart_;
  std::vector<bool> in_sheet_;
  SheetBorders counted_;
};

}  // namespace

SheetBorders borders_of(const VolumeProfiles& profiles, const EchoSteps& steps, const Sheet& sheet,
                        float least_step) {
  Borders borders(profiles, steps, sheet, least_step);
  for (const SheetPoint& point : sheet) borders.add(point);
  return borders.counted();
}

}  // namespace fanlight
