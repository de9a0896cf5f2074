#pragma once

#include <cstdint>
#include <string>

#include "proto/fanlight.pb.h"
#include "proto/probe_link.hpp"
#include "proto/result.hpp"

namespace fanlight {

/// Who may change the probe's settings over the network.
enum class ProbeControl : std::uint8_t { kEveryone, kNobody };

/// Where the state of the probe is kept for the displays, and where their wishes for it are numbered and
/// handed to the acquisition thread, which asks the probe. Server thread only.
class ProbeDesk {
 public:
  /// `link` must outlive the desk.
  ProbeDesk(ProbeLink& link, ProbeControl control) : link_(link), control_(control) {}

  /// Takes the newest state; true where one came.
  bool update();

  const ProbeStatus& status() const { return status_; }

  /// Orders a change and returns its number: it is answered when status().order_answered has come so far.
  /// Several within the same sweep may be answered as one. kUnavailable without a probe, kInvalidArgument
  /// where this is not allowed or a number is not finite; the ranges are the probe's to check.
  Result<std::uint64_t> order(const v1::ProbeSettings& change);

  v1::ProbeStatus message() const;

  /// For a person: "the probe FL-1 0007 streams: 70 deg, 35 frames a volume, 160 mm".
  std::string sentence() const;

  /// Whether a probe is waited for that was there before.
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
