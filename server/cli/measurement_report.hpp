// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace fanlight {

/// What `fanlight info` says of the measurements beside a recording: lines for people. Empty: there are none.
std::string measurement_lines(const std::filesystem::path& recording);

/// Adds "measurements", with numbers and their units, where there are any.
void add_measurements(nlohmann::ordered_json& report, const std::filesystem::path& recording);

}  // namespace fanlight
