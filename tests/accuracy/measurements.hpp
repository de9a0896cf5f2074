// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/figure_table.hpp"

namespace fanlight::test {

/// The inputs of a measurement. Rows for which `wants` is false are not rendered.
struct Workbench {
  BareGpu& gpu;
  std::function<bool(const std::string& row)> wants;
  std::function<void(Scene& defaults)> change;  ///< changes to the default scene (--set)
};

/// Small fans over each known surface: depths of pass 1 without speckle, normals, all passes with speckle,
/// and the steps from the paper's method to the default scene.
std::vector<FigureBlock> measure_small_fans(const Workbench& bench);

/// Counts the casts after changes of fields that only passes 2 and 3 read.
FigureBlock measure_relighting(const Workbench& bench);

/// Scenes as a scanner shows them: blurred by a beam, then log-compressed.
FigureBlock measure_scanned_scenes(const Workbench& bench);

/// Closed cavities of fluid as a scanner shows them: the error of their volume, grown from a point.
FigureBlock measure_fluid_volumes(const Workbench& bench);

/// Distances between points of a surface as a scanner shows it, from several directions.
FigureBlock measure_distances(const Workbench& bench);

/// Sequences of volumes with filter.steady, at rest and moving, beside single volumes.
FigureBlock measure_steady_sequences(const Workbench& bench);

/// A thin bright interface in pixels of 0.08 mm, and where each place of a surface puts it.
FigureBlock measure_thin_interface(const Workbench& bench);

/// The simulated womb, with and without its near tissue.
FigureBlock measure_wombs(const Workbench& bench);

/// The fetus before the wall of the uterus, as auto_scene() shows it.
FigureBlock measure_found_surfaces(const Workbench& bench);

/// The reference work (R1): the phantom of the simulated probe.
FigureBlock measure_reference_work(const Workbench& bench);

}  // namespace fanlight::test
