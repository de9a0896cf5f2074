// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "proto/base/result.hpp"
#include "server/rtp/rtp_sender.hpp"

namespace fanlight {

/// The options of the stream by RTP to an SFU.
struct RtpOptions {
  std::string to;  ///< empty: there is none
  bool start = false;
  std::string key;
  std::string sdp;
  int kbps = 4000;

  void add_to(CLI::App& command);

  /// nullopt: there is none. kInvalidArgument, kNotFound or kBadInput for what is wrong, and for a receiver
  /// on a network without a key: pictures of patients are not sent there for everyone to see. Reads the key.
  Result<std::optional<RtpSender::Config>> config() const;
};

}  // namespace fanlight
