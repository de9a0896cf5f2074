// SPDX-License-Identifier: Apache-2.0
#include "server/cli/igtl_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "proto/base/printable.hpp"
#include "server/net/listen_address.hpp"

namespace fanlight {

namespace {

Result<IgtlStreams> streams_in(std::string_view list) {
  IgtlStreams streams;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const std::string_view word = list.substr(0, comma);
    const auto* const known = std::ranges::find(kIgtlStreamNames, word, &IgtlStreamName::word);
    if (known == kIgtlStreamNames.end()) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("--igtl-send: there is no {}, expected some of picture, depth, surface, camera, video, "
                      "volume and frames, with commas between, or none",
                      printable(word))};
    }
    streams.set(static_cast<IgtlStream>(known - kIgtlStreamNames.begin()), true);
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return streams;
}

}  // namespace

void IgtlOptions::add_to(CLI::App& command) {
  command.option_defaults()->group("OpenIGTLink");
  command
      .add_option(
          "--igtl-listen", listen,
          "Serve 3D Slicer and others here, such as 127.0.0.1:18944; no encryption, no logins; default: "
          "nowhere")
      ->type_name("ADDRESS");
  command
      .add_option("--igtl-send", send,
                  "What clients get that ask for nothing: picture, depth, surface, camera, video, volume, "
                  "frames; with "
                  "commas; or none")
      ->capture_default_str()
      ->type_name("LIST");
  command
      .add_option("--igtl-spacing", spacing_mm,
                  "Spacing of the volume's grid for its clients, mm; 0: about 256 voxels on the longest side")
      ->check(CLI::IsMember({0.0}) | CLI::Range(0.05, 50.0))
      ->capture_default_str()
      ->type_name("MM");
  command
      .add_option("--igtl-role", role,
                  "What its clients may do: viewer, or operator; default: viewer where there are --tokens")
      ->check(CLI::IsMember({"viewer", "operator"}))
      ->type_name("ROLE");
}

Result<std::optional<IgtlServer::Config>> IgtlOptions::config(bool has_tls, bool has_tokens) const {
  if (listen.empty()) return std::optional<IgtlServer::Config>();
  const auto endpoint = parse_listen_address(listen);
  if (!endpoint) return endpoint.error();
  if (!endpoint->address().is_loopback() && !(has_tls && has_tokens)) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("--igtl-listen {} would let everyone on its network watch, since OpenIGTLink has neither "
                    "encryption nor logins; expected a loopback address such as 127.0.0.1:18944, or a server "
                    "that is set up for a network, with --tls-certificate, --tls-key and --tokens",
                    listen)};
  }
  const auto streams = streams_in(send == "none" ? "" : std::string_view(send));
  if (!streams) return streams.error();
  const std::string wanted = role.empty() ? (has_tokens ? "viewer" : "operator") : role;
  return std::optional(IgtlServer::Config{
      .endpoint = *endpoint, .usual = *streams, .spacing_mm = spacing_mm, .role = *find_role(wanted)});
}

}  // namespace fanlight
