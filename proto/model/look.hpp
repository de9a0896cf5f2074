// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// A named appearance of the surface: values for some fields of passes 2 and 3. Applying it sets these
/// fields; they can be changed afterwards like any others. Neither the position of the light nor anything
/// that moves the surface belongs to a look.
struct Look {
  struct Value {
    std::string_view field;  ///< name in scene_fields()
    std::string_view value;  ///< as set_field() takes it
  };
  std::string_view name;  ///< as on the command line
  std::string_view help;  ///< one clause for users
  std::span<const Value> values;
};

/// The default first. All looks set the same fields.
std::span<const Look> looks();

/// Sets the fields of the look with this name. The error names the known looks; the scene is then unchanged.
Result<void> apply_look(Scene& scene, std::string_view name);

}  // namespace fanlight
