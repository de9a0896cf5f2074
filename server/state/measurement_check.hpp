// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight {

/// Whether a measurement of a client or of a file may be kept: its texts can be shown, its numbers are finite
/// and its lists within the limits that fanlight.proto names. kInvalidArgument says what was expected.
Result<void> check_measurement(const v1::Measurement& measurement);

/// Whether a text may be the name of a measurement.
Result<void> check_measurement_name(const std::string& name);

}  // namespace fanlight
