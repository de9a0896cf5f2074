// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/survey/cell_sets.hpp"
#include "renderer/survey/echo_grid.hpp"

namespace fanlight {

/// Divides the levels of a grid, amplitudes, by that of the wall around a region, so that the wall is 1 on
/// all sides: echoes fade with depth, a wall that faces the beam is brighter, and one that lies in a shadow
/// darker. The wall's level in a direction, as seen from the middle of the region, is the greatest of the
/// means at equal distances from it, of what lies that way. Returns the level of the whole wall, in the unit
/// before.
double flatten_wall(EchoGrid& grid, const Cells& region);

}  // namespace fanlight
