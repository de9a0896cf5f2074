// SPDX-License-Identifier: Apache-2.0
#include "renderer/parameters/transfer_table.hpp"

#include <cmath>

namespace fanlight {

TransferTable transfer_table(const TransferFunction& transfer, double step_mm) {
  TransferTable table{};
  for (std::size_t level = 0; level < table.size(); ++level) {
    const TransferFunction::Value value = transfer.at(static_cast<double>(level));
    table[level] = {value.colour[0], value.colour[1], value.colour[2],
                    1 - std::pow(1 - value.opacity_per_mm, step_mm)};
  }
  return table;
}

}  // namespace fanlight
