// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "proto/base/result.hpp"

namespace fanlight {

/// An archive or a worklist server, and how it is reached.
struct DicomPeer {
  std::string called_title;  ///< its application entity title, 1 to 16 characters
  std::string host;
  std::uint16_t port = 0;
  std::string own_title = "FANLIGHT";
  bool tls = false;
  std::string ca_file;           ///< PEM; with TLS, the certificates that the peer's must be signed by
  std::string certificate_file;  ///< PEM; of this program, where the peer wants one
  std::string key_file;          ///< PEM
};

/// Reads TITLE@HOST:PORT; the host is a name or an IPv4 address. kInvalidArgument.
Result<DicomPeer> parse_dicom_peer(const std::string& text);

/// kInvalidArgument: not 1 to 16 printable ASCII characters without a backslash (PS3.5, VR AE).
Result<void> check_dicom_title(const std::string& title);

/// "TITLE@HOST:PORT", for messages.
std::string shown(const DicomPeer& peer);

}  // namespace fanlight
