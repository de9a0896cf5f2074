// SPDX-License-Identifier: Apache-2.0
// Values of the fields in the table of scene_fields.cpp, as numbers and as text.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "proto/model/scene.hpp"

namespace fanlight {

namespace {

std::string allowed(const SceneField& field) {
  if (!field.choices.empty()) return fmt::format("one of {}", fmt::join(field.choices, ", "));
  const std::string unit = field.unit.empty() ? "" : fmt::format(" {}", field.unit);
  const std::string step =
      field.step == 0 ? "" : fmt::format(" in steps of {} from {}", field.step, field.minimum);
  return fmt::format("a number from {} to {}{}{}", field.minimum, field.maximum, unit, step);
}

Error refusal(const SceneField& field, std::string_view given) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{} is {}, expected {}", field.name, given, allowed(field))};
}

}  // namespace

Result<void> set_field(Scene& scene, const SceneField& field, double value) {
  const bool in_range = value >= field.minimum && value <= field.maximum;  // false for a NaN
  const bool on_step = field.step == 0 || std::fmod(value - field.minimum, field.step) == 0;
  if (!in_range || !on_step) return refusal(field, fmt::format("{}", value));
  field.set(scene, value);
  return {};
}

Result<void> set_field(Scene& scene, const SceneField& field, std::string_view text) {
  if (field.is_text()) {
    auto set = field.set_text(scene, text);
    if (!set) return Error{set.error().code, fmt::format("{}: {}", field.name, set.error().message)};
    return {};
  }
  if (!field.choices.empty()) {
    const auto found = std::ranges::find(field.choices, text);
    if (found == field.choices.end()) return refusal(field, fmt::format("\"{}\"", text));
    field.set(scene, static_cast<double>(found - field.choices.begin()));
    return {};
  }
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || end != text.data() + text.size()) {
    return refusal(field, fmt::format("\"{}\"", text));
  }
  return set_field(scene, field, value);
}

std::string field_text(const Scene& scene, const SceneField& field) {
  if (field.is_text()) return field.get_text(scene);
  const double value = field.get(scene);
  return field.choices.empty() ? fmt::format("{}", value)
                               : std::string(field.choices[static_cast<std::size_t>(value)]);
}

}  // namespace fanlight
