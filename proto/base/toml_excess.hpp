// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace fanlight {

/// Why a text must not be given to toml11, whose time and memory grow with the square of the nesting, and
/// which calls itself for each level: "a key has more than 16 parts", "more than 16 brackets are open".
/// Empty: it may. Linear in the text.
std::string toml_excess(std::string_view text);

}  // namespace fanlight
