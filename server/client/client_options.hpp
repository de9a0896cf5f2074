// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>

#include "proto/base/result.hpp"
#include "server/client/stream_client.hpp"

namespace fanlight {

/// The options of a program that connects to a server as a display.
struct ClientOptions {
  StreamClient::Config server;
  std::string token_file;

  /// Adds them, and the URL. `this` must live as long as the command.
  void add_to(CLI::App& command);

  /// The server's configuration with the token, from the file or from FANLIGHT_TOKEN. Error, kNotFound: the
  /// file has none.
  Result<StreamClient::Config> config() const;
};

}  // namespace fanlight
