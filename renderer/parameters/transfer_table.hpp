// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/vec4.hpp>

#include "proto/model/transfer_function.hpp"

namespace fanlight {

/// The transfer function by grey level: colour, and the opacity of one sample of `step_mm`.
using TransferTable = std::array<glm::vec4, 256>;
TransferTable transfer_table(const TransferFunction& transfer, double step_mm);

}  // namespace fanlight
