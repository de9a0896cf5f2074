// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <toml.hpp>

#include "proto/base/result.hpp"

namespace fanlight {

/// Parses a geometry file. It is not trusted: its length, brackets and dots are limited, because the parser
/// calls itself for each. kBadInput names the file and the line.
Result<toml::value> parse_geometry_toml(const std::filesystem::path& path);

}  // namespace fanlight
