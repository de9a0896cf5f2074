// SPDX-License-Identifier: Apache-2.0
#include "server/net/allowed_origins.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>
#include <cctype>
#include <optional>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace urls = boost::urls;

namespace {

std::string lower(std::string_view text) {
  std::string copy(text);
  std::ranges::transform(copy, copy.begin(), [](unsigned char c) { return std::tolower(c); });
  return copy;
}

/// Whether a host has only what names and addresses have: others, such as ';', have a meaning in a
/// Content-Security-Policy.
bool is_plain(std::string_view host) {
  return std::ranges::all_of(host, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '.' || c == '[' || c == ']' || c == ':';
  });
}

/// The origin of a URL as browsers write it: in lower case, without the usual port of the scheme.
std::optional<std::string> origin_of(std::string_view text) {
  const auto url = urls::parse_uri(text);
  if (!url || !url->has_authority() || url->has_userinfo() || url->encoded_host().empty())
    return std::nullopt;
  const std::string scheme = lower(url->scheme());
  if (scheme != "http" && scheme != "https") return std::nullopt;
  const std::string_view port = url->port();
  const bool is_usual = port.empty() || port == (scheme == "https" ? "443" : "80");
  const std::string_view host = url->encoded_host();
  if (!is_plain(host)) return std::nullopt;
  return fmt::format("{}://{}{}", scheme, lower(host), is_usual ? "" : fmt::format(":{}", port));
}

}  // namespace

Result<AllowedOrigins> AllowedOrigins::parse(std::string_view text) {
  AllowedOrigins allowed;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    std::string_view each = text.substr(0, comma);
    while (each.starts_with(' ')) each.remove_prefix(1);
    while (each.ends_with(' ')) each.remove_suffix(1);
    const auto url = urls::parse_uri(each);
    auto origin = origin_of(each);
    if (!url || !origin || !url->encoded_resource().empty() || url->has_fragment()) {
      return Error{
          ErrorCode::kInvalidArgument,
          fmt::format("\"{}\" is no origin, expected a scheme, a host and a port where it is not the "
                      "usual one, such as https://ward.example or http://127.0.0.1:3000",
                      printable(each.substr(0, 80)))};
    }
    allowed.origins_.push_back(*std::move(origin));
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return allowed;
}

bool AllowedOrigins::has(std::string_view origin) const {
  return std::ranges::find(origins_, origin) != origins_.end();
}

bool AllowedOrigins::has_page(std::string_view referer) const {
  if (empty() || referer.empty()) return false;
  const auto origin = origin_of(referer);
  return origin && has(*origin);
}

std::string AllowedOrigins::sources() const {
  return empty() ? "'none'" : fmt::format("{}", fmt::join(origins_, " "));
}

}  // namespace fanlight
