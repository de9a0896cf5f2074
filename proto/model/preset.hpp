// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "proto/model/look.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// A named choice of what the picture shows and how: the fields of a look, of the surface and of the mode.
/// The view, the light's place and the crop box stay. A preset that looks for no surface of its own shows the
/// one that was found before, such as a skull.
struct Preset {
  std::string_view name;
  std::string_view help;                ///< one clause for users
  std::string_view look;                ///< its name
  std::span<const Look::Value> values;  ///< that differ from the look's and from those that all presets share
};

/// The default first. All presets set the same fields.
std::span<const Preset> presets();

/// Names of the fields that a preset sets, in the order in which they are set.
std::vector<std::string_view> preset_fields(const Preset& preset);

/// Of these, the fields of the surface that was found before: presets of a surface of their own have none.
std::vector<std::string_view> found_fields(const Preset& preset);

/// Sets the fields of the preset, those of found_fields() to values that suit skin in fluid.
void apply_preset(Scene& scene, const Preset& preset);

/// The same, with the values of found_fields() of `found`.
void apply_preset(Scene& scene, const Preset& preset, const Scene& found);

}  // namespace fanlight
