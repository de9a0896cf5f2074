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

/// Print one second of `fanlight watch` as a line of JSON, or for people. Sorts the ages. `statistics`: null
/// before the server has sent any; what it counts is null or left out then.
void print_json(WatchedSecond& second, const v1::Liveness& liveness, const v1::Statistics* statistics);
void print_text(WatchedSecond& second, const v1::Liveness& liveness, const v1::Statistics* statistics);

}  // namespace fanlight
