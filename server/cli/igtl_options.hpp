// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "proto/base/result.hpp"
#include "server/igtl/igtl_server.hpp"

namespace fanlight {

/// The options of the OpenIGTLink server.
struct IgtlOptions {
  std::string listen;  ///< empty: there is none
  std::string send = "picture,camera";
  double spacing_mm = 0;  ///< of the volume's grid; 0: about 256 voxels on the longest side
  std::string role;       ///< empty: by has_tokens

  void add_to(CLI::App& command);

  /// nullopt: there is none. kInvalidArgument for an address, a stream or a role that is wrong, and for an
  /// address of a network where the server has no TLS or no tokens: a server that others can watch needs
  /// decided so.
  Result<std::optional<IgtlServer::Config>> config(bool has_tls, bool has_tokens) const;
};

}  // namespace fanlight
