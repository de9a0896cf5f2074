// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "proto/fanlight.pb.h"

namespace fanlight {

/// Pictures received in one second.
struct WatchedSecond {
  int pictures = 0;
  std::size_t bytes = 0;
  std::vector<double> ages_ms;  ///< from the capture of a picture's last frame to its arrival here
};

/// Print one second of `fanlight watch` as a line of JSON, or for people. `age_ms`: from the capture of a
/// picture's last frame to its arrival, median.
void print_json(const WatchedSecond& second, double age_ms, const v1::Liveness& liveness,
                const v1::Statistics& statistics);
void print_text(const WatchedSecond& second, double age_ms, const v1::Liveness& liveness,
                const v1::Statistics& statistics);

}  // namespace fanlight
