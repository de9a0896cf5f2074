// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proto/base/result.hpp"

namespace fanlight {

/// What a relay sends, and how it arrives.
struct RelayReport {
  bool sending = false;
  std::string to;  ///< the receiver, as "HOST:PORT"
  bool encrypted = false;
  std::string description;  ///< SDP, which may hold the key; empty before the first picture

  struct Reception {
    double lost_percent = 0;        ///< of the packets since the report before
    std::int64_t lost_packets = 0;  ///< in all, less the duplicates; never negative
    double jitter_ms = 0;
  };
  std::optional<Reception> reception;  ///< of the receiver's last report; absent: none came for ten seconds
};

/// Sends the pictures of the main view to one receiver outside, such as an SFU. Server thread only.
class Relay {
 public:
  virtual ~Relay() = default;

  /// Error, kUnavailable: it already sends, or cannot.
  virtual Result<void> start() = 0;
  virtual void stop() = 0;
  virtual bool sending() const = 0;
  virtual std::string to() const = 0;
  virtual RelayReport report() const = 0;
};

}  // namespace fanlight
