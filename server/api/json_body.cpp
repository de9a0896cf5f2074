// SPDX-License-Identifier: Apache-2.0
#include "server/api/json_body.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

Error bad_body(std::string sentence) {
  return {ErrorCode::kInvalidArgument, std::move(sentence)};
}

}  // namespace

Result<nlohmann::json> object_with_keys(const std::string& body, std::span<const std::string_view> keys) {
  auto object = nlohmann::json::parse(body, nullptr, false);
  const std::string expected = fmt::format("expected a JSON object with {}", fmt::join(keys, ", "));
  if (object.is_discarded()) return bad_body("the body is no JSON, " + expected);
  if (!object.is_object()) return bad_body("the body is no object, " + expected);
  for (const auto& [key, value] : object.items()) {
    if (std::ranges::find(keys, key) == keys.end())
      return bad_body(fmt::format("the body has the key \"{}\", {}", printable(key.substr(0, 64)), expected));
  }
  return object;
}

std::string text_of(const nlohmann::json& object, std::string_view key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace fanlight
