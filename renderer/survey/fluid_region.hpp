// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/model/fan_geometry.hpp"
#include "proto/model/volume.hpp"
#include "renderer/survey/echo_grid.hpp"

namespace fanlight {

/// A region of fluid, closed all around by tissue: its volume and its border.
struct FluidRegion {
  double volume_mm3 = 0;
  double deviation_mm3 =
      0;                    ///< what the volume changes by where the border's level is 1.5 dB higher or lower
  double fluid_level = 0;   ///< mean grey level inside
  double border_level = 0;  ///< grey level of the border
  double wall_level = 0;    ///< grey level of the wall: see flatten_wall()
  /// The border in space, for drawing: it lies where `depths`, interpolated between the centres of the cells,
  /// pass through kBorder. Larger inside.
  CellBox box;
  std::vector<std::uint8_t> depths;  ///< of each cell
  static constexpr std::uint8_t kBorder = 128;
  static constexpr std::uint32_t kMostCellsASide = 48;  ///< of `box`
};

/// What is grown.
struct FluidSeed {
  Point at;  ///< in the fluid, transducer frame
  double border_db =
      0;  ///< moves the level of the border, kLeastBorderDb to kMostBorderDb: up for a larger region
};
inline constexpr double kLeastBorderDb = -12;
inline constexpr double kMostBorderDb = 3;  ///< 1.4 dB below the wall; above, tissue is as dark

/// Grows the region of fluid that holds the seed, as far as kMostFluidReachMm from it, to where the echo
/// is 4.4 dB below the wall on that side (renderer/ALGORITHM.md, fluid regions). Openings that are narrower
/// than about 3 mm are closed.
///
/// Errors, each with a sentence for people: kInvalidArgument: the seed is not in fluid, or the region is not
/// closed; kUnavailable: fewer than two frames; kStopped. Takes up to a few seconds and 200 MB;
/// std::bad_alloc where there is no memory. Any thread.
Result<FluidRegion> grown_fluid(const Volume& volume, const FluidSeed& seed, const std::stop_token& stop);

inline constexpr double kMostFluidReachMm = 75;

}  // namespace fanlight
