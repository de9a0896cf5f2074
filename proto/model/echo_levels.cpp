// SPDX-License-Identifier: Apache-2.0
#include "proto/model/echo_levels.hpp"

#include <fmt/format.h>

namespace fanlight {

std::string sentence(const EchoLevels& levels) {
  if (!levels.known) return "from the data: fluid and tissue cannot be distinguished";
  return fmt::format(
      "from the data: fluid {:.0f}, tissue {:.0f}, speckle {:.0f} grey levels{}; threshold {:.0f}, "
      "least tissue {:.0f}",
      levels.fluid, levels.tissue, levels.noise, levels.linear() ? " (not log-compressed)" : "",
      levels.threshold(), levels.least_tissue());
}

}  // namespace fanlight
