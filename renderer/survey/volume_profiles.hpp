// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <stop_token>
#include <vector>

#include "proto/model/volume.hpp"
#include "renderer/parameters/near_tissue.hpp"

namespace fanlight {

/// A coarse copy of a volume: mean grey levels along a grid of profiles, from the probe into the body, in
/// cells of about one millimetre. A profile is a bundle of columns of one frame: the scan lines of line
/// frames, parallel lines of Cartesian ones. Pixels outside the scanned sector belong to no cell.
class VolumeProfiles {
 public:
  static constexpr double kCellMm = 1;
  static constexpr std::uint32_t kMostAcross = 48;  ///< profiles of a frame
  static constexpr std::uint32_t kMostFrames = 40;
  static constexpr float kNoData = -1;

  /// Precondition: the volume has frames, sorted by angle. Where a stop is requested, the profiles are of no
  /// use.
  explicit VolumeProfiles(const Volume& volume, const std::stop_token& stop = {});

  std::uint32_t across() const { return across_; }
  std::uint32_t frames() const { return frames_; }
  std::uint32_t cells() const { return cells_; }
  std::uint32_t profiles() const { return across_ * frames_; }
  /// Length of a cell along a profile, mm.
  double cell_mm() const { return cell_mm_; }

  /// The cell, with a fraction, in which near tissue ends along a profile.
  double end_cell(std::uint32_t profile, const NearTissue& near) const;

  /// Sweep angle of a frame of profiles, ascending.
  double angle_rad(std::uint32_t frame) const { return angles_rad_[frame]; }

  /// Mean grey level; kNoData where the cell holds no scanned pixel. Profiles are numbered frame by frame.
  float level(std::uint32_t profile, std::uint32_t cell) const {
    return levels_[std::size_t{profile} * cells_ + cell];
  }

  /// Position in the transducer frame, mm, of a distance in cells along a profile.
  glm::dvec3 position(std::uint32_t profile, double cell) const;

 private:
  double middle_column(std::uint32_t profile) const;
  void fill(const Volume& volume, std::uint32_t frame, std::uint32_t index);

  FanGeometry geometry_;
  std::uint32_t across_ = 0;
  std::uint32_t frames_ = 0;
  std::uint32_t cells_ = 0;
  std::uint32_t rows_in_cell_ = 1;
  double cell_mm_ = kCellMm;
  std::vector<double> angles_rad_;  // of the frames
  std::vector<float> levels_;       // frames x across x cells
};

}  // namespace fanlight
