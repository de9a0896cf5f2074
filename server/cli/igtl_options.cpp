// SPDX-License-Identifier: Apache-2.0
#include "server/cli/igtl_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "proto/base/printable.hpp"
#include "server/net/listen_address.hpp"

namespace fanlight {

namespace {

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

Result<IgtlStreams> streams_in(std::string_view list) {
  IgtlStreams streams;
  if (trimmed(list) == "none") return streams;
  for (bool first = true; first || !list.empty(); first = false) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const std::string_view word = trimmed(list.substr(0, comma));
    const auto* const known = std::ranges::find(kIgtlStreamNames, word, &IgtlStreamName::word);
    if (known == kIgtlStreamNames.end()) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format(
              "--igtl-send: there is no stream \"{}\", expected some of picture, depth, surface, camera, "
              "video, volume and frames, with commas between, or the word none alone",
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
  auto* const needed = command
                           .add_option("--igtl-listen", listen,
                                       "Address for OpenIGTLink clients such as 3D Slicer: 127.0.0.1:18944; "
                                       "no encryption, no logins; default: "
                                       "nowhere")
                           ->type_name("ADDRESS");
  command
      .add_option("--igtl-send", send,
                  "Streams for clients that request none: picture, depth, surface, camera, video, volume, "
                  "frames, "
                  "separated by commas; or none")
      ->capture_default_str()
      ->type_name("LIST");
  command
      .add_option(
          "--igtl-spacing", spacing_mm,
          "Grid spacing of volumes for OpenIGTLink clients, 0.05 to 50 mm; 0: about 256 voxels along the "
          "longest side")
      ->check([](const std::string& text) {
        double value = 0;
        const char* const end = text.data() + text.size();
        const auto read = std::from_chars(text.data(), end, value);
        const bool is_number = read.ec == std::errc{} && read.ptr == end;
        const bool good = is_number && (value == 0 || (value >= 0.05 && value <= 50));  // no NaN
        return good ? "" : fmt::format("Value {} is neither 0 nor in range 0.05 to 50", text);
      })
      ->capture_default_str()
      ->type_name("MM");
  command
      .add_option("--igtl-role", role,
                  "Role of OpenIGTLink clients: viewer or operator; default: viewer if there are --tokens")
      ->check(CLI::IsMember({"viewer", "operator"}))
      ->needs(needed)
      ->type_name("ROLE");
}

Result<std::optional<IgtlServer::Config>> IgtlOptions::config(bool has_tls, bool has_tokens) const {
  if (listen.empty()) {
    // Not by the parser: a configuration may have each of them with its default.
    const IgtlOptions usual;
    const char* const given = send != usual.send               ? "--igtl-send"
                              : spacing_mm != usual.spacing_mm ? "--igtl-spacing"
                                                               : nullptr;
    if (given == nullptr) return std::optional<IgtlServer::Config>();
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("{} needs --igtl-listen, expected an address such as 127.0.0.1:18944 there", given)};
  }
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
  const auto streams = streams_in(send);
  if (!streams) return streams.error();
  const std::string wanted = role.empty() ? (has_tokens ? "viewer" : "operator") : role;
  return std::optional(IgtlServer::Config{
      .endpoint = *endpoint, .usual = *streams, .spacing_mm = spacing_mm, .role = *find_role(wanted)});
}

}  // namespace fanlight
