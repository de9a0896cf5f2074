// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// Phase of a picture: idle -> casting (bands of pass 1 are submitted one by one, and the weights of the
/// depth filter, if any, also for a changed light) -> lighting (passes 2 and 3 were submitted, the picture is
/// not collected yet) -> idle. A changed light goes from idle to lighting.
enum class WorkPhase : std::uint8_t { kIdle, kCasting, kLighting };

}  // namespace fanlight
