// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>

#include "proto/base/result.hpp"
#include "server/pacs/archive.hpp"

namespace fanlight {

/// The options of a command that calls a DICOM peer.
struct PacsOptions {
  std::string peer;
  std::string own_title = "FANLIGHT";
  std::string ca_file;
  std::string certificate_file;
  std::string key_file;
  std::string http_login;  ///< a file; with a URL only

  /// Adds them except the peer, which each command names in its own way. `this` must live as long as the
  /// command.
  void add_to(CLI::App& command);

  /// kInvalidArgument.
  Result<DicomPeer> dicom_peer() const;

  /// An archive by the peer's title or by a URL. kInvalidArgument.
  Result<Archive> archive() const;
};

}  // namespace fanlight
