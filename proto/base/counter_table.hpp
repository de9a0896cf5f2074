// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <variant>

#include "proto/base/counter.hpp"

namespace fanlight {

/// How a count behaves over time, which decides the name of its metric.
enum class CountKind : std::uint8_t {
  kTotal,  ///< fanlight_NAME_total: only grows
  kNow,    ///< fanlight_NAME: the present number
};

/// One row of the table of a struct of counters: the member, and its metric.
template <typename Counters>
struct CountRow {
  const char* name;
  const char* help;
  std::variant<Counter Counters::*, Gauge<std::uint64_t> Counters::*> member;
  CountKind kind = CountKind::kTotal;

  std::uint64_t value(const Counters& counters) const {
    return std::visit([&counters](auto pointer) { return (counters.*pointer).value(); }, member);
  }
};

/// The same for a value that goes up and down: fanlight_NAME.
template <typename Counters>
struct ValueRow {
  const char* name;
  const char* help;
  Gauge<double> Counters::*member;

  double value(const Counters& counters) const { return (counters.*member).value(); }
};

}  // namespace fanlight
