// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/base/result.hpp"
#include "proto/exchange/probe_link.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight {

/// Who may change the settings of the probe over the network.
enum class ProbeControl : std::uint8_t { kEveryone, kNobody };

/// The probe as the server sees it: keeps the newest state of the probe, and passes changes of its settings
/// as numbered orders to the acquisition thread, which sends them to the probe. Server thread only.
class ProbeProxy {
 public:
  /// `link` must outlive this object.
  ProbeProxy(ProbeLink& link, ProbeControl control) : link_(link), control_(control) {}

  /// Reads the newest state; false if there is no new one.
  bool update();

  const ProbeStatus& status() const { return status_; }

  /// Orders a change and returns its number. The order is answered when status().order_answered has reached
  /// that number; several orders within one sweep may be answered together. Errors: kUnavailable without a
  /// probe; kInvalidArgument if changes are not allowed or a number is not finite. The probe checks the
  /// ranges.
  Result<std::uint64_t> order(const v1::ProbeSettings& change);

  v1::ProbeStatus message() const;

  /// A sentence for the log: "the probe FL-1 0007 streams: 70 deg, 35 frames a volume, 160 mm".
  std::string sentence() const;

  /// Whether the probe was connected and is not any more.
  const std::string& trouble() const { return status_.trouble; }
  bool lost() const { return status_.state == ProbeStatus::State::kLost; }

 private:
  ProbeLink& link_;
  ProbeControl control_;
  ProbeStatus status_;
  ProbeOrder last_order_;
};

/// The settings as a message with every field present.
v1::ProbeSettings settings_message(const probe::Settings& settings);

}  // namespace fanlight
