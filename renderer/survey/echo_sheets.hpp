// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "proto/model/scene.hpp"
#include "renderer/survey/volume_profiles.hpp"

namespace fanlight {

/// Length of the mean on either side of a step, mm.
inline constexpr double kSurveyWindowMm = 5;

/// Where in a profile steps are looked for, in cells.
struct CellRange {
  int first = 0;
  int end = 0;
};

/// Every cell of every profile.
std::vector<CellRange> all_cells(const VolumeProfiles& profiles);

/// Steps of the echo along all profiles: mean of the cells behind minus mean of the cells before, or the
/// reverse for steps from bright to dark.
class EchoSteps {
 public:
  /// `ranges`: of each profile; `profiles` must outlive this.
  EchoSteps(const VolumeProfiles& profiles, std::vector<CellRange> ranges, EdgeSign sign);

  EdgeSign sign() const { return sign_; }

  float at(std::uint32_t profile, std::uint32_t cell) const {
    return steps_[std::size_t{profile} * profiles_.cells() + cell];
  }

  /// The first cell of a local maximum of at least `least` at or behind `from`; -1: none.
  int first_peak(std::uint32_t profile, int from, float least) const;

  /// Median size of all steps; 0 in a volume without noise.
  double clutter() const;

 private:
  void fill(std::uint32_t profile);

  const VolumeProfiles& profiles_;
  std::vector<CellRange> ranges_;
  EdgeSign sign_;
  int window_;
  std::vector<float> steps_;  // profiles x cells; 0 also where a window has no data
  std::vector<float> sizes_;  // of those with data
};

/// A step of a profile.
struct SheetPoint {
  std::uint32_t profile = 0;
  int cell = 0;
  float step = 0;
};

/// At most one point of a profile, in order of profiles.
using Sheet = std::vector<SheetPoint>;

/// Of the largest steps of each profile that hang together with those of its neighbours, the sheet with the
/// largest sum. `least_step`: grey levels; with small steps sheets grow together, with large ones they fall
/// apart.
Sheet strongest_sheet(const VolumeProfiles& profiles, const EchoSteps& steps, float least_step);

/// The same of the `most` sheets with the largest sums, the largest first.
std::vector<Sheet> strongest_sheets(const VolumeProfiles& profiles, const EchoSteps& steps, float least_step,
                                    std::size_t most);

/// Median step of a sheet, grey levels.
double contrast_of(const Sheet& sheet);

}  // namespace fanlight
