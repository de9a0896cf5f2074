// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "server/state/server_state.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// All counters and values in the text format of Prometheus.
std::string metrics_text(const ServerState& state, const PictureHub& hub);

}  // namespace fanlight
