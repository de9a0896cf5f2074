// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

namespace fanlight {

/// What the frames of a volume say about their grey levels, 0 to 255, for the fields of a scene that ask for
/// values from the data (renderer/parameters/effective_scene.hpp).
struct EchoLevels {
  double fluid = 0;    ///< median of the dark blocks
  double tissue = 0;   ///< median of the bright blocks
  double noise = 0;    ///< standard deviation of the speckle in bright blocks
  bool known = false;  ///< false: the frames show nothing, and the other values mean nothing
  bool flat = false;   ///< not known, since the echo differs by no more than its speckle: there is no surface

  /// The step that makes a surface: a share of what lies between fluid and tissue. Small, since
  /// the halves of a detector's window reach beyond a thin bright surface, and a slanted one steps slowly;
  /// but no less than the speckle that is left in their means. Where the frames are flat, more than any step.
  double threshold() const;
  /// How far the echo has risen from the fluid's to the tissue's at a surface: see echo_levels.cpp.
  /// `reach`: Scene::Detector::reach.
  double rise(double reach) const;
  /// How far below its peak a thin bright sheet has its front, grey levels: see echo_levels.cpp.
  double sheet_below() const;
  /// What is darker behind an edge is no tissue: next to a body's outline rays meet its blurred rim, not the
  /// body. Less than half of the way from fluid to tissue, since echoes fade with depth and in shadows
  /// (measured: renderer/RESULTS.md).
  double least_tissue() const { return known ? std::lerp(fluid, tissue, 0.4) : 0; }
  /// Least difference of the echo before and behind a surface, grey levels, 0 to 255; 0 where nothing is
  /// known of the speckle. In flat frames so much that less than 0.5 % of the rays show a surface. `reduced`:
  /// a filter reduces the speckle.
  double least_contrast(bool reduced) const;
  /// Whether the speckle's deviation is proportional to its mean, as without log compression.
  bool linear() const { return noise > kLeastLinearRatio * tissue; }

  /// Grey levels of a decibel of log-compressed frames, by the deviation of fully developed speckle.
  double levels_per_db() const;

  /// Whether there is log-compressed speckle, of which the lengths of rises were measured.
  bool in_decibels() const { return known && !linear() && noise >= 1; }

  /// Between the ratios of log-compressed pictures (0.12 to 0.2) and of Rayleigh's distribution (0.52).
  static constexpr double kLeastLinearRatio = 0.35;

  bool operator==(const EchoLevels&) const = default;
};

/// For people: the values, and what follows from them.
std::string sentence(const EchoLevels& levels);

}  // namespace fanlight
