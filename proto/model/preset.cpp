// SPDX-License-Identifier: Apache-2.0
#include "proto/model/preset.hpp"

#include <algorithm>
#include <array>

namespace fanlight {

namespace {

// What the search for the surface chooses, with its usual values.
constexpr Look::Value kSurface[] = {{"detector.threshold", "0"},         {"detector.least_tissue", "0"},
                                    {"detector.least_contrast", "0"},    {"detector.window_mm", "6"},
                                    {"detector.sign", "dark-to-bright"}, {"detector.place", "level"},
                                    {"near.before_bone", "shown"}};

// What every preset sets as well, where its own values do not differ.
constexpr Look::Value kCommon[] = {
    {"mode", "surface"},       {"filter.size_mm", "6"},        {"finish.colours", "none"},
    {"glass.amount", "0"},     {"fill_light.red", "1"},        {"fill_light.green", "1"},
    {"fill_light.blue", "1"},  {"fill_light.strength", "0.5"}, {"back_light.red", "1"},
    {"back_light.green", "1"}, {"back_light.blue", "1"},       {"back_light.strength", "0.5"}};

// A small window keeps folds and creases; less light goes under the skin, and shadows are open.
constexpr Look::Value kSkinPreset[] = {{"filter.size_mm", "4"},
                                       {"material.scatter_mm", "0.6"},
                                       {"light.specular", "0.05"},
                                       {"shadow.coefficient", "0.35"},
                                       {"finish.exposure", "1.6"}};

// The wall behind the fetus is darker and cooler still than in the look, and fluid is lighter. A cool light
// fills the shadows; a warm one from behind gives edges.
constexpr Look::Value kBabyPreset[] = {
    {"filter.size_mm", "5"},     {"light.half_mm", "25"},       {"light.haze", "0.008"},
    {"finish.exposure", "2"},    {"fill_light.on", "on"},       {"fill_light.red", "0.7"},
    {"fill_light.green", "0.8"}, {"fill_light.blue", "1"},      {"fill_light.strength", "0.12"},
    {"back_light.on", "on"},     {"back_light.red", "1"},       {"back_light.green", "0.9"},
    {"back_light.blue", "0.8"},  {"back_light.strength", "0.4"}};

// The bright line behind which the echo falls: bone throws a shadow, and the inside of a skull is dark.
constexpr Look::Value kBonePreset[] = {{"detector.window_mm", "10"},
                                       {"detector.sign", "bright-to-dark"},
                                       {"detector.place", "ridge"},
                                       {"near.before_bone", "removed"}};

// Where the echo falls: the near border of what is dark, such as a bladder, a cyst or a vessel.
constexpr Look::Value kFluidPreset[] = {{"detector.sign", "bright-to-dark"}, {"finish.colours", "ice"}};

// The outlines of a body of glass before a dark ground. Tissue before a skull would lie over it as a fog.
constexpr Look::Value kSilhouettePreset[] = {{"glass.amount", "1"}, {"near.before_bone", "removed"}};

constexpr Look::Value kDepthPreset[] = {{"mode", "depth"}, {"finish.colours", "gold"}};

constexpr Preset kPresets[] = {
    {"face", "the surface, smooth, in warm light", "skin", {}},
    {"skin", "the surface with its folds and creases", "skin", kSkinPreset},
    {"bone", "the near side of a skull, or the first border from bright to dark behind near tissue",
     "clinical", kBonePreset},
    {"depth", "how far the surface is: near is bright", "clinical", kDepthPreset},
    {"baby", "the surface in warm light before a far field that is darker and cooler", "skin", kBabyPreset},
    {"fluid", "the near border of fluid, such as a bladder or a cyst; crop or cut away what hides it",
     "clinical", kFluidPreset},
    {"silhouette", "the surface as glass: its outlines, and those of what lies behind it", "skin",
     kSilhouettePreset},
};

/// The values in the order in which they are set.
std::array<std::span<const Look::Value>, 4> layers(const Preset& preset) {
  return {std::ranges::find(looks(), preset.look, &Look::name)->values, kSurface, kCommon, preset.values};
}

bool sets(const Preset& preset, std::string_view field) {
  return std::ranges::find(preset.values, field, &Look::Value::field) != preset.values.end();
}

void set(Scene& scene, const Look::Value& value) {
  // A unit test sets every value of every preset.
  static_cast<void>(set_field(scene, *find_scene_field(value.field), value.value));
}

}  // namespace

std::span<const Preset> presets() {
  return kPresets;
}

std::vector<std::string_view> preset_fields(const Preset& preset) {
  std::vector<std::string_view> names;
  for (const auto& values : layers(preset)) {
    for (const Look::Value& value : values) {
      if (std::ranges::find(names, value.field) == names.end()) names.push_back(value.field);
    }
  }
  return names;
}

std::vector<std::string_view> found_fields(const Preset& preset) {
  // The sign says on which side of the surface the echo is brighter.
  if (sets(preset, "detector.sign")) return {};
  std::vector<std::string_view> names;
  for (const Look::Value& value : kSurface) {
    if (!sets(preset, value.field)) names.push_back(value.field);
  }
  return names;
}

void apply_preset(Scene& scene, const Preset& preset) {
  for (const auto& values : layers(preset)) {
    for (const Look::Value& value : values) set(scene, value);
  }
}

void apply_preset(Scene& scene, const Preset& preset, const Scene& found) {
  apply_preset(scene, preset);
  for (const std::string_view name : found_fields(preset)) find_scene_field(name)->copy(scene, found);
}

}  // namespace fanlight
