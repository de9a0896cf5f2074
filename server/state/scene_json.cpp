// SPDX-License-Identifier: Apache-2.0
#include "server/state/scene_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "proto/base/nearest_name.hpp"
#include "proto/base/printable.hpp"
#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;
using Value = std::variant<double, std::string>;

/// The value of "light.right_mm" in {"light": {"right_mm": ...}}; makes it if it is not there.
ordered_json& value_at(ordered_json& object, std::string_view name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos) return object[std::string(name)];
  return object[std::string(name.substr(0, dot))][std::string(name.substr(dot + 1))];
}

ordered_json value_json(const SceneField& field, const Value& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  const double number = std::get<double>(value);
  if (!field.choices.empty()) {
    const auto index = static_cast<std::size_t>(number);
    return index < field.choices.size() ? ordered_json(field.choices[index]) : ordered_json(number);
  }
  const bool whole = number == std::floor(number) && std::abs(number) < 1e15;
  return whole ? ordered_json(static_cast<std::int64_t>(number)) : ordered_json(number);
}

Error wrong(std::string_view name, std::string_view expected) {
  return {ErrorCode::kInvalidArgument, fmt::format("{}: expected {}", name, expected)};
}

Result<void> read_field(v1::Scene& change, const SceneField& field, const json& value) {
  if (field.is_text()) {
    if (!value.is_string()) return wrong(field.name, "a text");
    put_change(change, field, value.get<std::string>());
    return {};
  }
  if (value.is_string() && !field.choices.empty()) {
    const auto choice = std::ranges::find(field.choices, value.get<std::string>());
    if (choice == field.choices.end()) {
      return Error{ErrorCode::kInvalidArgument,
                   fmt::format("{}: expected one of {}", field.name, fmt::join(field.choices, ", "))};
    }
    put_change(change, field, static_cast<double>(choice - field.choices.begin()));
    return {};
  }
  if (!value.is_number()) {
    return wrong(field.name, field.choices.empty()
                                 ? "a number"
                                 : fmt::format("one of {}", fmt::join(field.choices, ", ")));
  }
  const double number = value.get<double>();
  // The message has an unsigned integer for this field, so that other numbers must be refused here.
  if (field.step >= 1 && field.minimum >= 0 &&
      !(number >= 0 && number <= 1e9 && number == std::floor(number))) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("{}: expected a whole number of {} to {}",
                                                          field.name, field.minimum, field.maximum)};
  }
  put_change(change, field, number);
  return {};
}

Result<void> read_fields(v1::Scene& change, const json& object, const std::string& prefix) {
  for (const auto& [key, value] : object.items()) {
    const std::string name = prefix + key;
    if (const SceneField* field = find_scene_field(name); field != nullptr) {
      if (auto read = read_field(change, *field, value); !read) return read;
    } else if (value.is_object() && prefix.empty()) {
      if (auto read = read_fields(change, value, key + "."); !read) return read;
    } else {
      return no_scene_field(name);
    }
  }
  return {};
}

}  // namespace

ordered_json scene_json(const Scene& scene) {
  ordered_json object;
  for (const SceneField& field : scene_fields()) {
    value_at(object, field.name) =
        field.is_text() ? ordered_json(field.get_text(scene)) : value_json(field, field.get(scene));
  }
  return object;
}

Error no_scene_field(const std::string& name) {
  std::vector<std::string> known;
  for (const SceneField& field : scene_fields()) known.emplace_back(field.name);
  const std::string meant = nearest_name(name, known);
  return wrong(printable(name), meant.empty() ? "the name of a field of the scene, such as light.right_mm"
                                              : fmt::format("a field of the scene, did you mean {}?", meant));
}

Result<v1::Scene> scene_change_from_json(const json& change) {
  if (!change.is_object()) return wrong("the scene", "an object with some of its fields");
  v1::Scene message;
  if (auto read = read_fields(message, change, ""); !read) return read.error();
  return message;
}

ordered_json change_json(const v1::Scene& change) {
  ordered_json object = ordered_json::object();
  for_each_change(change, [&](const SceneField& field, const Value& value) {
    value_at(object, field.name) = value_json(field, value);
  });
  return object;
}

ordered_json range_json(const SceneField& field) {
  ordered_json range = {{"field", field.name}};
  if (!field.choices.empty()) range["choices"] = field.choices;
  if (field.is_text() || !field.choices.empty()) return range;
  range["minimum"] = value_json(field, field.minimum);
  range["maximum"] = value_json(field, field.maximum);
  return range;
}

}  // namespace fanlight
