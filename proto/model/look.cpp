// SPDX-License-Identifier: Apache-2.0
#include "proto/model/look.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <vector>

namespace fanlight {

namespace {

constexpr Look::Value kSkin[] = {{"material.red", "0.93"},     {"material.green", "0.57"},
                                 {"material.blue", "0.42"},    {"material.scatter_mm", "1.8"},
                                 {"material.glow", "0.8"},     {"light.red", "1"},
                                 {"light.green", "0.95"},      {"light.blue", "0.88"},
                                 {"light.ambient", "0.05"},    {"light.diffuse", "1"},
                                 {"light.specular", "0.09"},   {"light.shininess", "16"},
                                 {"light.occlusion", "1"},     {"light.occlusion_mm", "9"},
                                 {"light.fade_mm", "3"},       {"light.rim", "0.12"},
                                 {"light.half_mm", "35"},      {"light.haze", "0.004"},
                                 {"light.normals", "central"}, {"shadow.coefficient", "0.03"},
                                 {"shadow.softness_mm", "30"}, {"light.on", "on"},
                                 {"light.strength", "1"},      {"fill_light.on", "off"},
                                 {"back_light.on", "off"},     {"finish.smoothing", "mean"},
                                 {"finish.colours", "none"},   {"finish.exposure", "2.1"},
                                 {"finish.outline", "3"},      {"finish.tone", "film"}};

constexpr Look::Value kClinical[] = {
    {"material.red", "0.92"},     {"material.green", "0.89"},    {"material.blue", "0.84"},
    {"material.scatter_mm", "0"}, {"material.glow", "0"},        {"light.red", "1"},
    {"light.green", "1"},         {"light.blue", "1"},           {"light.ambient", "0.45"},
    {"light.diffuse", "0.55"},    {"light.specular", "0.04"},    {"light.shininess", "12"},
    {"light.occlusion", "1"},     {"light.occlusion_mm", "8"},   {"light.fade_mm", "0"},
    {"light.rim", "0"},           {"light.half_mm", "0"},        {"light.haze", "0"},
    {"light.normals", "central"}, {"shadow.coefficient", "0.6"}, {"shadow.softness_mm", "20"},
    {"light.on", "on"},           {"light.strength", "1"},       {"fill_light.on", "off"},
    {"back_light.on", "off"},     {"finish.smoothing", "mean"},  {"finish.colours", "none"},
    {"finish.exposure", "0.9"},   {"finish.outline", "3"},       {"finish.tone", "linear"}};

constexpr Look::Value kPaper[] = {
    {"material.red", "0.95"},     {"material.green", "0.78"},    {"material.blue", "0.68"},
    {"material.scatter_mm", "0"}, {"material.glow", "0"},        {"light.red", "1"},
    {"light.green", "1"},         {"light.blue", "1"},           {"light.ambient", "0.2"},
    {"light.diffuse", "0.75"},    {"light.specular", "0.25"},    {"light.shininess", "24"},
    {"light.occlusion", "0"},     {"light.occlusion_mm", "12"},  {"light.fade_mm", "0"},
    {"light.rim", "0"},           {"light.half_mm", "0"},        {"light.haze", "0"},
    {"light.normals", "central"}, {"shadow.coefficient", "0.3"}, {"shadow.softness_mm", "15"},
    {"light.on", "on"},           {"light.strength", "1"},       {"fill_light.on", "off"},
    {"back_light.on", "off"},     {"finish.smoothing", "mean"},  {"finish.colours", "none"},
    {"finish.exposure", "1"},     {"finish.outline", "0"},       {"finish.tone", "linear"}};

constexpr Look kLooks[] = {
    {"skin", "warm light that goes under the skin, for viewing", kSkin},
    {"clinical", "even light that shows the shape, for reading and measuring", kClinical},
    {"paper", "the light of the published method: matt, shiny and a shadow", kPaper},
};

Scene with(Scene scene, const Look& look) {
  for (const Look::Value& value : look.values) {
    // A unit test sets every value of every look.
    static_cast<void>(set_field(scene, *find_scene_field(value.field), value.value));
  }
  return scene;
}

}  // namespace

std::span<const Look> looks() {
  return kLooks;
}

Result<void> apply_look(Scene& scene, std::string_view name) {
  const auto* const found = std::ranges::find(kLooks, name, &Look::name);
  if (found == std::end(kLooks)) {
    std::vector<std::string_view> names;
    for (const Look& look : kLooks) names.push_back(look.name);
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the look is \"{}\", expected one of {}", name, fmt::join(names, ", "))};
  }
  scene = with(scene, *found);
  return {};
}

}  // namespace fanlight
