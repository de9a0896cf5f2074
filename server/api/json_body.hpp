// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// The body of a request as an object without other keys than these. Errors, kInvalidArgument: it is no JSON
/// object, or has another key.
Result<nlohmann::json> object_with_keys(const std::string& body, std::span<const std::string_view> keys);

/// The text of a key; empty where there is none, or it is no text.
std::string text_of(const nlohmann::json& object, std::string_view key);

}  // namespace fanlight
