// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// A millisecond in nanoseconds, the unit of the times that tests give to the code.
constexpr std::int64_t kMs = 1'000'000;

}  // namespace fanlight
