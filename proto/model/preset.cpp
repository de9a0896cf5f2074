// SPDX-License-Identifier: Apache-2.0
#include "proto/model/preset.hpp"

#include <algorithm>

namespace fanlight {

namespace {

constexpr Look::Value kFacePreset[] = {{"mode", "surface"},
                                       {"filter.size_mm", "6"},
                                       {"detector.threshold", "0"},
                                       {"detector.least_tissue", "0"},
                                       {"detector.least_contrast", "0"},
                                       {"detector.window_mm", "6"},
                                       {"detector.sign", "dark-to-bright"},
                                       {"detector.place", "level"},
                                       {"near.before_bone", "shown"},
                                       {"finish.colours", "none"}};

// A small window keeps folds and creases; less light goes under the skin, and shadows are open.
constexpr Look::Value kSkinPreset[] = {{"mode", "surface"},
                                       {"filter.size_mm", "3"},
                                       {"detector.threshold", "0"},
                                       {"detector.least_tissue", "0"},
                                       {"detector.least_contrast", "0"},
                                       {"detector.window_mm", "6"},
                                       {"detector.sign", "dark-to-bright"},
                                       {"detector.place", "level"},
                                       {"near.before_bone", "shown"},
                                       {"finish.colours", "none"},
                                       {"material.scatter_mm", "0.6"},
                                       {"light.specular", "0.3"},
                                       {"shadow.coefficient", "0.35"},
                                       {"finish.exposure", "1.6"}};

// The bright line behind which the echo falls: bone throws a shadow, and the inside of a skull is dark.
constexpr Look::Value kBonePreset[] = {{"mode", "surface"},
                                       {"filter.size_mm", "6"},
                                       {"detector.threshold", "0"},
                                       {"detector.window_mm", "10"},
                                       {"detector.sign", "bright-to-dark"},
                                       {"detector.place", "ridge"},
                                       {"detector.least_tissue", "0"},
                                       {"detector.least_contrast", "0"},
                                       {"near.before_bone", "removed"},
                                       {"finish.colours", "none"}};

constexpr Look::Value kDepthPreset[] = {{"mode", "depth"},
                                        {"filter.size_mm", "6"},
                                        {"detector.threshold", "0"},
                                        {"detector.least_tissue", "0"},
                                        {"detector.least_contrast", "0"},
                                        {"detector.window_mm", "6"},
                                        {"detector.sign", "dark-to-bright"},
                                        {"detector.place", "level"},
                                        {"near.before_bone", "shown"},
                                        {"finish.colours", "gold"}};

constexpr Preset kPresets[] = {
    {"face", "the surface, smooth, in warm light", "skin", kFacePreset},
    {"skin", "the surface with its folds and creases", "skin", kSkinPreset},
    {"bone", "the near side of a skull, or the first border from bright to dark", "clinical", kBonePreset},
    {"depth", "how far the surface is: near is bright", "clinical", kDepthPreset},
};

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
  for (const Look::Value& value : std::ranges::find(looks(), preset.look, &Look::name)->values)
    names.push_back(value.field);
  for (const Look::Value& value : preset.values) {
    if (std::ranges::find(names, value.field) == names.end()) names.push_back(value.field);
  }
  return names;
}

void apply_preset(Scene& scene, const Preset& preset) {
  static_cast<void>(apply_look(scene, preset.look));
  for (const Look::Value& value : preset.values) set(scene, value);
}

}  // namespace fanlight
