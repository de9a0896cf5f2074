// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/near_tissue_survey.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "renderer/survey/profile_map.hpp"
#include "renderer/survey/shell_survey.hpp"
#include "renderer/survey/volume_profiles.hpp"

namespace fanlight {

namespace {

// Of the way from fluid to tissue: what is darker is fluid. Near tissue fades with depth, and fluid next to
// it is lifted by the beam's width.
constexpr double kFluidShare = 0.3;
// Cells of fluid in a row that end the near tissue.
constexpr int kLeastGapCells = 2;
// The probe's own echo; what begins later is no near tissue.
constexpr double kLeastTissueMm = 3;
constexpr double kMostTissueMm = 60;
// The map lies so far behind the near tissue, at most in the middle of the fluid.
constexpr double kMapBehindMm = 3;
// A profile whose tissue ends so far from its neighbours' median belongs to something that touches it.
constexpr double kMostApartMm = 6;
constexpr int kMapNeighbours = 3;  // profiles to either side
// Of the profiles with a gap, those that agree with their neighbours. Measured: 0.95 or more in wombs, 0.7
// and 0.77 in two real heads that touch the tissue before them, whose brain passes for fluid.
constexpr double kLeastInAgreement = 0.85;
constexpr double kLeastKnown = 0.4;
constexpr double kLeastBegun = 0.15;
constexpr int kSmoothings = 12;
// SteadyNearTissue.
constexpr float kShareOfNewMap = 0.3F;
constexpr float kJumpMm = 5;
constexpr float kLeftMm = 0.5F;
constexpr double kOtherAngleRad = 0.01;
constexpr std::uint32_t kMostWithout = 3;

/// The fluid behind the near tissue of one profile, in cells.
struct Gap {
  bool known = false;
  bool open = false;  ///< the profile begins in fluid: there is no near tissue, and the map ends before `end`
  double first = 0;
  double end = 0;
};

/// The gaps of all profiles.
class Gaps {
 public:
  Gaps(const VolumeProfiles& profiles, double fluid_level)
      : profiles_(profiles), gaps_(profiles.profiles()), map_(profiles) {
    for (std::uint32_t profile = 0; profile < profiles.profiles(); ++profile)
      gaps_[profile] = gap_of(profile, fluid_level);
  }

  /// Of the profiles that begin in tissue.
  double known_share() const {
    const auto begun = std::ranges::count(gaps_, false, &Gap::open);
    const auto known = std::ranges::count_if(gaps_, &Gap::known);
    return begun > 0 ? static_cast<double>(known) / static_cast<double>(begun) : 0;
  }
  /// Of all profiles.
  double begun_share() const {
    return static_cast<double>(std::ranges::count(gaps_, false, &Gap::open)) /
           static_cast<double>(gaps_.size());
  }

  /// Forgets gaps that lie elsewhere than those around them.
  void drop_outliers() {
    std::vector<bool> out(gaps_.size());
    std::vector<double> around;
    for (std::uint32_t profile = 0; profile < gaps_.size(); ++profile) {
      if (!gaps_[profile].known) continue;
      around.clear();
      map_.for_neighbours(profile, kMapNeighbours, [&](std::uint32_t other, double) {
        if (gaps_[other].known) around.push_back(gaps_[other].first);
      });
      const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
      std::ranges::nth_element(around, middle);
      out[profile] = std::abs(gaps_[profile].first - *middle) * profiles_.cell_mm() > kMostApartMm;
    }
    for (std::uint32_t profile = 0; profile < gaps_.size(); ++profile) gaps_[profile].known &= !out[profile];
  }

  /// A smooth map through the gaps, over the profiles without one too. Precondition: one is known.
  const ProfileMap& smooth_map() {
    for (std::uint32_t profile = 0; profile < gaps_.size(); ++profile) {
      const Gap& gap = gaps_[profile];
      if (gap.known)
        map_.set(profile,
                 gap.first + std::min((gap.end - gap.first) / 2, kMapBehindMm / profiles_.cell_mm()));
    }
    map_.fill();
    map_.smooth(kSmoothings,
                [this](std::uint32_t profile, double cell) { return within_gap(profile, cell); });
    return map_;
  }

 private:
  Gap gap_of(std::uint32_t profile, double fluid_level) const {
    const int cells = static_cast<int>(profiles_.cells());
    const auto level = [&](int cell) { return profiles_.level(profile, static_cast<std::uint32_t>(cell)); };
    int first = 0;
    while (first < cells && level(first) < 0) ++first;
    const int last = std::min(cells, first + static_cast<int>(kMostTissueMm / profiles_.cell_mm()));
    int tissue = 0;
    int dark = 0;
    for (int cell = first; cell < last; ++cell) {
      dark = level(cell) >= 0 && level(cell) < fluid_level ? dark + 1 : 0;
      tissue += dark == 0 ? 1 : 0;
      if (dark < kLeastGapCells) continue;
      int end = cell + 1;
      while (end < cells && level(end) >= 0 && level(end) < fluid_level) ++end;
      const bool is_open = tissue * profiles_.cell_mm() < kLeastTissueMm;
      return {
          .known = !is_open, .open = is_open, .first = cell + 1.0 - dark, .end = static_cast<double>(end)};
    }
    return {};
  }

  /// Behind the near tissue, and before what is behind the fluid.
  double within_gap(std::uint32_t profile, double cell) const {
    const Gap& gap = gaps_[profile];
    if (gap.open) return std::min(cell, gap.end);
    if (!gap.known) return cell;
    const double half = (gap.end - gap.first) / 2;
    const double behind = std::min(half, kMapBehindMm / profiles_.cell_mm());
    return std::clamp(cell, gap.first + behind / 2, std::max(gap.first + behind, gap.end - behind));
  }

  const VolumeProfiles& profiles_;
  std::vector<Gap> gaps_;
  ProfileMap map_;
};

}  // namespace

std::optional<NearTissue> find_near_tissue(const Volume& volume, const EchoLevels& levels) {
  if (!levels.known || volume.stamp().frames < 2) return std::nullopt;
  const VolumeProfiles profiles(volume);
  if (profiles.across() < 2 || profiles.frames() < 2 || profiles.cells() == 0) return std::nullopt;
  Gaps gaps(profiles, std::lerp(levels.fluid, levels.tissue, kFluidShare));
  const double with_gap = gaps.known_share();
  gaps.drop_outliers();
  if (gaps.known_share() < kLeastInAgreement * with_gap) return std::nullopt;
  if (gaps.known_share() < kLeastKnown || gaps.begun_share() < kLeastBegun) return std::nullopt;
  return gaps.smooth_map().near_tissue(volume);
}

NearTissueSearch search_near_tissue(const Volume& volume, const EchoLevels& levels,
                                    const Scene::Near& wanted) {
  NearTissueSearch search;
  search.for_bone = wanted.before_bone == NearTissueShow::kRemoved;
  // Tissue without a contrast has no bone, and rings of a probe in air have none.
  const bool may_have_bone = !levels.flat && !volume.stamp().warnings.has(SweepWarning::kRings);
  if (search.for_bone && may_have_bone) {
    if (const auto shell = find_shell(volume)) search.found = shell->before;
    search.ends_at_bone = search.found.has_value();
  }
  search.for_fluid = !search.found && wanted.is_removed();
  if (search.for_fluid) search.found = find_near_tissue(volume, levels);
  return search;
}

void SteadyNearTissue::add(NearTissueSearch& search, const Scene::Near& wanted, const FanGeometry& geometry) {
  const bool is_same_search = wanted.tissue == wanted_.tissue && wanted.before_bone == wanted_.before_bone;
  if (geometry != geometry_ || !is_same_search) *this = {};
  geometry_ = geometry;
  wanted_ = wanted;
  // Where fluid is found instead of the bone in force, or the reverse, that counts as nothing found.
  const bool agrees = search.found && (!in_force_ || search.ends_at_bone == ends_at_bone_);
  without_ = agrees ? 0 : without_ + 1;
  if (without_ >= kMostWithout) mean_ = in_force_ = std::nullopt;
  if (search.found && (agrees || !in_force_)) {
    ends_at_bone_ = search.ends_at_bone;
    follow(*search.found);
  }
  search.found = in_force_;
  if (in_force_) search.ends_at_bone = ends_at_bone_;
}

void SteadyNearTissue::follow(const NearTissue& found) {
  if (!mean_) {
    mean_ = in_force_ = found;
    return;
  }
  const auto rows = [this](float length_mm) {
    return length_mm / static_cast<float>(geometry_.pixel_height_mm);
  };
  const auto differs = [](double one, double other) { return std::abs(one - other) > kOtherAngleRad; };
  bool has_left = differs(found.first_angle_rad, in_force_->first_angle_rad) ||
                  differs(found.last_angle_rad, in_force_->last_angle_rad);
  mean_->first_angle_rad = found.first_angle_rad;
  mean_->last_angle_rad = found.last_angle_rad;
  for (std::size_t point = 0; point < found.end_row.size(); ++point) {
    float& row = mean_->end_row[point];
    const float apart = found.end_row[point] - row;
    row += std::abs(apart) > rows(kJumpMm) ? apart : kShareOfNewMap * apart;
    has_left |= std::abs(row - in_force_->end_row[point]) > rows(kLeftMm);
  }
  if (has_left) in_force_ = mean_;
}

}  // namespace fanlight
