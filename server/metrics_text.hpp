#pragma once

#include <string>

#include "server/stream_context.hpp"

namespace fanlight {

/// Every counter of the house in Prometheus' text format.
std::string metrics_text(const StreamContext& context);

}  // namespace fanlight
