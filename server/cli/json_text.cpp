// SPDX-License-Identifier: Apache-2.0
#include "server/cli/json_text.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

namespace fanlight {

namespace {

void round_numbers(nlohmann::ordered_json& value) {
  if (value.is_number_float() && std::isfinite(value.get<double>())) {
    value = std::strtod(fmt::format("{:.7g}", value.get<double>()).c_str(), nullptr);
  } else if (value.is_structured()) {
    for (auto& each : value) round_numbers(each);
  }
}

}  // namespace

std::string json_text(const nlohmann::ordered_json& report, int indent) {
  nlohmann::ordered_json rounded = report;
  round_numbers(rounded);
  // Names of files may be of any bytes.
  return rounded.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace fanlight
