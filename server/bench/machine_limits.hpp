// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace fanlight {

/// What the processors of this machine can do at most, measured: the fastest of several runs, on all of them
/// at once.
struct MachineLimits {
  std::size_t processors = 1;
  std::string vectors;   ///< the instruction set, "AVX2", "AVX-512"
  double gigahertz = 0;  ///< of each, by a chain of multiplications of three cycles each
  double read_gb_s = 0;  ///< from memory, of all together
  double gather_ns =
      0;  ///< a gathered word and processor, where neighbours lie side by side in the first cache
  double far_gather_ns = 0;  ///< the same, of words anywhere in 16 MB
  double gflop_s = 0;        ///< single precision multiplications and additions, of all together
};

/// Takes some seconds and 1 GB.
MachineLimits measure_machine_limits();

}  // namespace fanlight
