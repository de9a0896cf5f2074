// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>

#include "proto/base/result.hpp"
#include "server/pacs/dicom_peer.hpp"

namespace fanlight {

/// The options of a command that calls a DICOM peer.
struct PacsOptions {
  std::string peer;
  std::string own_title = "FANLIGHT";
  std::string ca_file;
  std::string certificate_file;
  std::string key_file;

  /// Adds them except the peer, which each command names in its own way. `this` must live as long as the
  /// command.
  void add_to(CLI::App& command);

  /// kInvalidArgument.
  Result<DicomPeer> dicom_peer() const;
};

}  // namespace fanlight
