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

/// What the plugs of one emulated probe share: its model, its faults, and the lock around both. Every member
/// is read and written under `mutex`.
struct ProbeCore {
  explicit ProbeCore(std::unique_ptr<ProbeModel> with_model) : model(std::move(with_model)) {}

  /// Lets a fault happen, or waits with it for the transfer or the request that it is of, and counts it. Of
  /// unplug and replug it only takes the wish, and wakes `changed`.
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
  std::optional<FaultKind> plug_wish;  ///< unplug or replug; the probe is silent until it came true
  std::condition_variable changed;     ///< a plug_wish came, or the script has a new next moment
};

}  // namespace fanlight::test
