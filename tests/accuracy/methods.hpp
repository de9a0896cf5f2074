// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "proto/model/scene.hpp"

namespace fanlight::test {

/// A method of rendering, as changes to the default scene.
struct Method {
  std::string_view name;
  void (*change)(Scene& defaults);
};

/// From the method of the paper to the default scene, one addition at a time.
std::span<const Method> methods();
inline constexpr std::size_t kPaperMethod = 0;

/// The scene without speckle reduction and depth filters: the depth map is that of pass 1.
Scene cast_alone(Scene scene);

/// The same numbers for every volume: no windows in mm, nothing from the data, the steepest point.
void with_fixed_numbers(Scene& scene);

}  // namespace fanlight::test
