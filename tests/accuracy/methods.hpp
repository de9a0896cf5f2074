#pragma once

#include <span>
#include <string_view>

#include "proto/scene.hpp"

namespace fanlight::test {

/// A way to render, as what it changes of the default scene.
struct Method {
  std::string_view name;
  void (*change)(Scene& defaults);
};

/// From the paper's own method to the default scene, one addition at a time.
std::span<const Method> methods();
inline constexpr std::size_t kPaperMethod = 0;

/// Pass 1 alone: no speckle reduction, and the depth map left as it was cast.
Scene cast_alone(Scene scene);

}  // namespace fanlight::test
