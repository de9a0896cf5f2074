// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "server/bench/stage_overlap.hpp"

namespace fanlight {

/// A block as a picture, SVG: time runs to the right, in ms; a lane each for passes 0 and 1, for passes 2 and
/// 3, and for the encoder; a volume has the same colour in all of them.
std::string trace_picture(const BlockTrace& block);

}  // namespace fanlight
