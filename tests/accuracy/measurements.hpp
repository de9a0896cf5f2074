#pragma once

#include <functional>
#include <string>

#include "renderer/gpu.hpp"
#include "tests/accuracy/figure_table.hpp"

namespace fanlight::test {

/// What a block of rows needs to be measured. A row that nobody wants is not rendered.
struct Workbench {
  const Gpu& gpu;
  std::function<bool(const std::string& row)> wants;
  std::function<void(Scene& defaults)> change;  ///< what to try instead of the default scene
};

/// The small fans over each known surface: pass 1 alone without speckle, its normals, the whole chain with
/// speckle, and the method's steps.
std::vector<FigureBlock> measure_small_fans(const Workbench& bench);

/// Whether a changed field of passes 2 and 3 casts rays.
FigureBlock measure_relighting(const Workbench& bench);

/// The reference work (R1), as the simulated probe sees its phantom.
FigureBlock measure_reference_work(const Workbench& bench);

}  // namespace fanlight::test
