// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/dicom_peer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "proto/base/printable.hpp"

namespace fanlight {

Result<void> check_dicom_title(const std::string& title) {
  constexpr std::size_t kMostCharacters = 16;
  const bool known = std::ranges::all_of(title, [](char c) { return c >= ' ' && c <= '~' && c != '\\'; });
  const bool blank = title.find_first_not_of(' ') == std::string::npos;
  if (known && !blank && title.size() <= kMostCharacters) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("\"{}\" is no application entity title, expected 1 to 16 characters, such as ARCHIVE",
                  printable(title))};
}

Result<DicomPeer> parse_dicom_peer(const std::string& text) {
  const auto wrong = [&] {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("\"{}\" is no DICOM peer, expected TITLE@HOST:PORT, such as ARCHIVE@10.0.0.5:11112",
                    printable(text))};
  };
  const std::size_t at = text.find('@');
  const std::size_t colon = text.rfind(':');
  if (at == std::string::npos || colon == std::string::npos || colon < at) return wrong();
  DicomPeer peer;
  peer.called_title = text.substr(0, at);
  peer.host = text.substr(at + 1, colon - at - 1);
  // DCMTK 3.6.7 takes the last colon of an address for that of the port.
  if (peer.host.find_first_of("[]:") != std::string::npos) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("\"{}\" has an IPv6 address, expected a name or an IPv4 address", printable(text))};
  }
  const char* const end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data() + colon + 1, end, peer.port);
  if (problem != std::errc{} || rest != end || peer.port == 0 || peer.host.empty()) return wrong();
  if (auto title = check_dicom_title(peer.called_title); !title) return title.error();
  return peer;
}

std::string shown(const DicomPeer& peer) {
  return fmt::format("{}@{}:{}", printable(peer.called_title), printable(peer.host), peer.port);
}

}  // namespace fanlight
