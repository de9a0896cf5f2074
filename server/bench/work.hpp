// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "proto/model/scene.hpp"
#include "server/bench/rows.hpp"
#include "server/bench/volumes.hpp"

namespace fanlight {

/// What a row renders: its volumes, and the default scene of their source with the settings of the row.
struct BenchWork {
  BenchVolumes volumes;
  Scene scene;
  int picture = 0;  ///< side of the picture in pixels

  /// Reads `count` volumes of the row's source. Errors: those of BenchVolumes::create(), and a setting that
  /// is no field of a scene.
  static Result<BenchWork> create(const BenchRow& row, std::uint32_t count);
};

}  // namespace fanlight
