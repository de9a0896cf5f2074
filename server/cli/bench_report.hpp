// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "server/bench/pipeline.hpp"
#include "server/bench/rate.hpp"
#include "server/bench/rows.hpp"

namespace fanlight {

// The figures of a row as `fanlight bench pipeline` and `bench rate` print them: as JSON, or as text on
// standard output.

nlohmann::ordered_json as_json(const BenchRow& row, const PipelineTimes& times);
void print_pipeline(const BenchRow& row, const PipelineTimes& times);

using RowRates = std::array<RateFigures, 2>;
nlohmann::ordered_json as_json(const BenchRow& row, const RowRates& rates);
void print_rates_head();
void print_rates(const BenchRow& row, const RowRates& rates);

}  // namespace fanlight
