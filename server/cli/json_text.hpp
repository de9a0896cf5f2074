// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace fanlight {

/// A report as text, its numbers rounded to seven digits: 18.24, not 18.240000000000002. `indent`: -1 for one
/// line.
std::string json_text(const nlohmann::ordered_json& report, int indent = -1);

}  // namespace fanlight
