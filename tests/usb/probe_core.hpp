// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include "tests/usb/fault_script.hpp"
#include "tests/usb/probe_model.hpp"

namespace fanlight::test {

/// Shared state of all plugs of one emulated probe: its model, its faults, and their lock. All members are
/// accessed under `mutex`.
struct ProbeCore {
  explicit ProbeCore(std::unique_ptr<ProbeModel> with_model) : model(std::move(with_model)) {}

  /// Executes a fault, or stores it until its transfer or request, and counts it. Unplug and replug are only
  /// stored, and wake `changed`.
  void carry_out(const Fault& fault, std::int64_t now_ns);

  std::mutex mutex;
  std::unique_ptr<ProbeModel> model;
  FaultScript script;
  std::array<std::uint64_t, static_cast<std::size_t>(FaultKind::kReplug) + 1> carried_out{};

  // Faults of the bus.
  std::optional<FaultKind> of_next_transfer;  ///< stall, error or overflow
  bool halted = false;
  bool late_identity = false;
  std::int64_t mute_until_ns = 0;
  std::optional<FaultKind> plug_wish;  ///< unplug or replug; the probe is silent until it is done
  std::condition_variable changed;     ///< a plug_wish was set, or the script's next time changed
};

}  // namespace fanlight::test
