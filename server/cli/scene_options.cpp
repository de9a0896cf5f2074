// SPDX-License-Identifier: Apache-2.0
#include "server/cli/scene_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "proto/model/look.hpp"
#include "proto/model/preset.hpp"
#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

/// The default. Empty for a field whose default depends on the geometry of the fan: it differs
/// between two fans.
std::string default_of(const SceneField& field) {
  const FanGeometry small{.columns = 64,
                          .rows = 64,
                          .pixel_width_mm = 1,
                          .pixel_height_mm = 1,
                          .face_column = 20,
                          .motor_radius_mm = 20};
  FanGeometry large = small;
  large.rows = 200;
  large.columns = 300;
  const Scene of_small = scene_for(small, -0.4, 0.5);
  if (!field.same(of_small, scene_for(large, -0.8, 0.7))) return "";
  return field_text(of_small, field);
}

std::string help_of(const SceneField& field) {
  if (field.is_text() || !field.choices.empty()) return std::string(field.help);
  return fmt::format("{} ({} to {}{}{})", field.help, field.minimum, field.maximum,
                     field.unit.empty() ? "" : " ", field.unit);
}

std::string value_of(const SceneField& field) {
  if (field.is_text()) return "TEXT";
  return field.choices.empty() ? "NUMBER" : fmt::format("{}", fmt::join(field.choices, "|"));
}

/// The group in --help: "Scene: camera" for camera.yaw_deg.
std::string group_of(const SceneField& field) {
  const std::size_t dot = field.name.find('.');
  return dot == std::string_view::npos ? "Scene" : fmt::format("Scene: {}", field.name.substr(0, dot));
}

}  // namespace

void SceneOptions::add_to(CLI::App& command) {
  command.footer("Scene options without a default here depend on the geometry of the fan.");
  std::vector<std::string> lines;
  std::vector<std::string_view> names;
  for (const Look& look : looks()) {
    lines.push_back(fmt::format("{}: {}", look.name, look.help));
    names.push_back(look.name);
  }
  std::vector<std::string> preset_lines;
  for (const Preset& preset : presets())
    preset_lines.push_back(fmt::format("{}: {}", preset.name, preset.help));
  command
      .add_option(
          "--preset", preset_,
          fmt::format(
              "sets what the picture shows and how, before --look and the fields below: a built-in preset "
              "by its name, or all fields of a JSON file, as the page exports presets; {}",
              fmt::join(preset_lines, "; ")))
      ->type_name("NAME|FILE")
      ->group("Scene");
  command
      .add_option("--look", look_,
                  fmt::format("sets several of the fields below, which can still be set one by one; {}",
                              fmt::join(lines, "; ")))
      ->type_name(fmt::format("{}", fmt::join(names, "|")))
      ->group("Scene");
  for (const SceneField& field : scene_fields()) {
    auto& given = given_.emplace_back(&field, "");
    command.add_option(fmt::format("--{}", field.name), given.second, help_of(field))
        ->type_name(value_of(field))
        ->default_str(default_of(field))
        ->group(group_of(field));
  }
}

bool SceneOptions::choose_view() const {
  return std::ranges::any_of(given(), [](const SceneField* field) {
    return field->name == "mode" || field->name.starts_with("camera.") || field->name.starts_with("rays.");
  });
}

std::vector<const SceneField*> SceneOptions::given() const {
  std::vector<const SceneField*> fields;
  for (const auto& [field, text] : given_) {
    if (!text.empty()) fields.push_back(field);
  }
  return fields;
}

Result<Scene> SceneOptions::with_preset(Scene scene) const {
  if (preset_.empty()) return scene;
  // The page writes their names with a capital.
  const auto lower = [](char letter) {
    return letter >= 'A' && letter <= 'Z' ? letter + ('a' - 'A') : +letter;
  };
  const auto known = std::ranges::find_if(
      presets(), [&](const Preset& preset) { return std::ranges::equal(preset_, preset.name, {}, lower); });
  if (known != presets().end()) {
    apply_preset(scene, *known, Scene(scene));
    return scene;
  }
  if (!preset_.ends_with(".json")) {
    std::vector<std::string_view> names;
    for (const Preset& preset : presets()) names.push_back(preset.name);
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the preset is \"{}\", expected one of {}, or a file.json", preset_,
                             fmt::join(names, ", "))};
  }
  std::ifstream file(preset_);
  if (!file) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{} cannot be opened, expected a preset in a JSON file", preset_)};
  }
  auto json = nlohmann::json::parse(file, nullptr, false);
  if (json.is_discarded()) {
    return Error{
        ErrorCode::kBadInput,
        fmt::format("{} cannot be read as JSON, expected a preset that the page has exported", preset_)};
  }
  if (json.is_object() && json.contains("scene")) json = json["scene"];  // an answer of /api/scene
  const auto change = scene_change_from_json(json);
  if (!change) return Error{ErrorCode::kBadInput, fmt::format("{}: {}", preset_, change.error().message)};
  auto changed = changed_scene(scene, *change);
  if (!changed) return Error{ErrorCode::kBadInput, fmt::format("{}: {}", preset_, changed.error().message)};
  return changed;
}

Result<Scene> SceneOptions::applied_to(const Scene& unchanged) const {
  auto with = with_preset(unchanged);
  if (!with) return with;
  Scene scene = *with;
  if (!look_.empty()) {
    if (auto set = apply_look(scene, look_); !set) return set.error();
  }
  for (const auto& [field, text] : given_) {
    if (text.empty()) continue;
    if (auto set = set_field(scene, *field, std::string_view(text)); !set) return set.error();
  }
  if (auto whole = check(scene); !whole) return whole.error();
  return scene;
}

}  // namespace fanlight
