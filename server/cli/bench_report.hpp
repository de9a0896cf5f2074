// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <span>

#include "renderer/vulkan/render_device.hpp"
#include "server/bench/memory.hpp"
#include "server/bench/pipeline.hpp"
#include "server/bench/rate.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

/// What a report says about the device that it was measured on: its name, kind and driver.
nlohmann::ordered_json report_of(const RenderDevice& device);

// The figures of a row as `fanlight bench pipeline`, `bench rate` and `bench memory` print them: as JSON, or
// as text on standard output.

nlohmann::ordered_json as_json(const BenchRow& row, const PipelineTimes& times);
void print_pipeline(const BenchRow& row, const PipelineTimes& times);

using RowRates = std::array<RateFigures, 2>;
nlohmann::ordered_json as_json(const BenchRow& row, const RowRates& rates);
void print_rates_head();
void print_rates(const BenchRow& row, const RowRates& rates);

nlohmann::ordered_json as_json(const HeldMemory& held);
void print_held(const HeldMemory& held);
nlohmann::ordered_json as_json(std::span<const MemoryPart> parts);
void print_parts(std::span<const MemoryPart> parts);

}  // namespace fanlight
