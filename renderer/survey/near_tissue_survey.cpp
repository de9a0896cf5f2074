// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/near_tissue_survey.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

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

class Map {
 public:
  Map(const VolumeProfiles& profiles, double fluid_level)
      : profiles_(profiles), gaps_(profiles.profiles()), value_(profiles.profiles()) {
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
      for_neighbours(profile, kMapNeighbours, [&](std::uint32_t other, double) {
        if (gaps_[other].known) around.push_back(gaps_[other].first);
      });
      const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
      std::ranges::nth_element(around, middle);
      out[profile] = std::abs(gaps_[profile].first - *middle) * profiles_.cell_mm() > kMostApartMm;
    }
    for (std::uint32_t profile = 0; profile < gaps_.size(); ++profile) gaps_[profile].known &= !out[profile];
  }

  /// A smooth map through the gaps, over the profiles without one too.
  void smooth() {
    fill();
    for (int round = 0; round < kSmoothings; ++round) {
      const std::vector<double> before = value_;
      for (std::uint32_t profile = 0; profile < gaps_.size(); ++profile) {
        double sum = 0;
        double weights = 0;
        for_neighbours(profile, 1, [&](std::uint32_t other, double weight) {
          sum += weight * before[other];
          weights += weight;
        });
        value_[profile] = within_gap(profile, sum / weights);
      }
    }
  }

  /// In cells, at a profile of each frame, with a fraction, and at an angle.
  double at(double across, double angle_rad) const {
    const double column = std::clamp(across, 0.0, profiles_.across() - 1.0);
    const double frame = frame_at(angle_rad);
    const auto left = std::min(static_cast<std::uint32_t>(column), profiles_.across() - 2);
    const auto below = std::min(static_cast<std::uint32_t>(frame), profiles_.frames() - 2);
    const double* const from = &value_[std::size_t{below} * profiles_.across() + left];
    const double* const next = from + profiles_.across();
    return std::lerp(std::lerp(from[0], from[1], column - left), std::lerp(next[0], next[1], column - left),
                     frame - below);
  }

 private:
  double frame_at(double angle_rad) const {
    std::uint32_t above = 1;
    while (above + 1 < profiles_.frames() && profiles_.angle_rad(above) < angle_rad) ++above;
    const double below_rad = profiles_.angle_rad(above - 1);
    const double step_rad = profiles_.angle_rad(above) - below_rad;
    const double share = step_rad > 0 ? (angle_rad - below_rad) / step_rad : 0;
    return above - 1 + std::clamp(share, 0.0, 1.0);
  }

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

  template <typename Use>
  void for_neighbours(std::uint32_t profile, int reach, Use&& use) const {
    const int across = static_cast<int>(profiles_.across());
    const int frames = static_cast<int>(profiles_.frames());
    const int column = static_cast<int>(profile) % across;
    const int frame = static_cast<int>(profile) / across;
    for (int z = std::max(0, frame - reach); z <= std::min(frames - 1, frame + reach); ++z) {
      for (int x = std::max(0, column - reach); x <= std::min(across - 1, column + reach); ++x)
        use(static_cast<std::uint32_t>(z * across + x), z == frame && x == column ? 2.0 : 1.0);
    }
  }

  /// Behind the near tissue, and before what is behind the fluid.
  double within_gap(std::uint32_t profile, double value) const {
    const Gap& gap = gaps_[profile];
    if (gap.open) return std::min(value, gap.end);
    if (!gap.known) return value;
    const double half = (gap.end - gap.first) / 2;
    const double behind = std::min(half, kMapBehindMm / profiles_.cell_mm());
    return std::clamp(value, gap.first + behind / 2, std::max(gap.first + behind, gap.end - behind));
  }

  /// Behind the near tissue where a gap is known; elsewhere the mean of the nearest ones.
  void fill() {
    std::vector<bool> has(gaps_.size());
    for (std::uint32_t profile = 0; profile < gaps_.size(); ++profile) {
      has[profile] = gaps_[profile].known;
      if (!has[profile]) continue;
      const double half = (gaps_[profile].end - gaps_[profile].first) / 2;
      value_[profile] = gaps_[profile].first + std::min(half, kMapBehindMm / profiles_.cell_mm());
    }
    for (bool any = true; any;) {
      any = false;
      std::vector<bool> grown = has;
      for (std::uint32_t profile = 0; profile < gaps_.size(); ++profile) {
        if (has[profile]) continue;
        double sum = 0;
        int count = 0;
        for_neighbours(profile, 1, [&](std::uint32_t other, double) {
          if (!has[other]) return;
          sum += value_[other];
          ++count;
        });
        if (count == 0) continue;
        value_[profile] = sum / count;
        grown[profile] = any = true;
      }
      has = std::move(grown);
    }
  }

  const VolumeProfiles& profiles_;
  std::vector<Gap> gaps_;
  std::vector<double> value_;  // cells
};

}  // namespace

std::optional<NearTissue> find_near_tissue(const Volume& volume, const EchoLevels& levels) {
  if (!levels.known || volume.stamp().frames < 2) return std::nullopt;
  const VolumeProfiles profiles(volume);
  if (profiles.across() < 2 || profiles.frames() < 2 || profiles.cells() == 0) return std::nullopt;
  Map map(profiles, std::lerp(levels.fluid, levels.tissue, kFluidShare));
  const double with_gap = map.known_share();
  map.drop_outliers();
  if (map.known_share() < kLeastInAgreement * with_gap) return std::nullopt;
  if (map.known_share() < kLeastKnown || map.begun_share() < kLeastBegun) return std::nullopt;
  map.smooth();

  const auto order = volume.by_angle();
  NearTissue found{.first_angle_rad = volume.angles_rad()[order.front()],
                   .last_angle_rad = volume.angles_rad()[order.back()]};
  if (!(found.last_angle_rad > found.first_angle_rad)) return std::nullopt;
  const double rows = profiles.cell_mm() / volume.geometry().pixel_height_mm;
  const double columns = volume.geometry().columns;
  for (std::uint32_t z = 0; z < NearTissue::kAround; ++z) {
    const double angle_rad =
        std::lerp(found.first_angle_rad, found.last_angle_rad, z / (NearTissue::kAround - 1.0));
    for (std::uint32_t x = 0; x < NearTissue::kAcross; ++x) {
      // A profile lies in the middle of its columns.
      const double column = x / (NearTissue::kAcross - 1.0) * (columns - 1);
      const double cell = map.at((column + 0.5) / columns * profiles.across() - 0.5, angle_rad);
      found.end_row[std::size_t{z} * NearTissue::kAcross + x] = static_cast<float>(cell * rows);
    }
  }
  return found;
}

void SteadyNearTissue::add(const std::optional<NearTissue>& found, const FanGeometry& geometry) {
  if (geometry != geometry_) *this = {};
  geometry_ = geometry;
  without_ = found ? 0 : without_ + 1;
  if (found) follow(*found);
  if (without_ >= kMostWithout) mean_ = in_force_ = std::nullopt;
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
