// SPDX-License-Identifier: Apache-2.0
#include "server/client/client_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <fstream>

namespace fanlight {

Result<StreamClient::Config> ClientOptions::config() const {
  StreamClient::Config config = server;
  if (token_file.empty()) {
    // Not an option: other users of the machine can see a command line.
    const char* const token = std::getenv("FANLIGHT_TOKEN");  // NOLINT(concurrency-mt-unsafe): one thread yet
    config.token = token != nullptr ? token : "";
    return config;
  }
  std::ifstream file(token_file);
  if (file >> config.token) return config;
  return Error{ErrorCode::kNotFound, fmt::format("{} has no token in it, expected one", token_file)};
}

void ClientOptions::add_to(CLI::App& command) {
  command.add_option("URL", server.url, "Server: a URL, a host, or a port on this machine")
      ->capture_default_str()
      ->type_name("URL");
  command
      .add_option("--token-file", token_file,
                  "File with the access token; default: the variable FANLIGHT_TOKEN")
      ->type_name("FILE");
  command
      .add_option("--server-ca", server.server_ca,
                  "CA certificate that signs the server's certificate; default: those of the system")
      ->type_name("FILE");
  auto* const certificate =
      command.add_option("--certificate", server.certificate, "Client certificate, instead of a token")
          ->type_name("FILE");
  command.add_option("--key", server.key, "Private key of the client certificate")
      ->needs(certificate)
      ->type_name("FILE");
  command.add_option("--name", server.name, "Name of this display, shown to others")->type_name("TEXT");
}

}  // namespace fanlight
