// SPDX-License-Identifier: Apache-2.0
#include "server/http/request_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/beast/core/string.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>
#include <cctype>
#include <string_view>

namespace fanlight {

namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace urls = boost::urls;

namespace {

constexpr unsigned kHttp10 = 10;

RequestViolation bad_request(std::string sentence) {
  return {.status = http::status::bad_request, .sentence = std::move(sentence)};
}

std::optional<RequestViolation> length_violation(const RequestHeader& header) {
  const auto codings = header.count(http::field::transfer_encoding);
  if (codings == 0) {
    if (header.count(http::field::content_length) > 1)
      return bad_request("the request has several Content-Length headers, expected one");
    return std::nullopt;
  }
  if (codings > 1 || !beast::iequals(header[http::field::transfer_encoding], "chunked"))
    return bad_request("the Transfer-Encoding is not served, expected chunked or none");
  if (header.count(http::field::content_length) > 0)
    return bad_request("the request has a Content-Length and a Transfer-Encoding, expected one of them");
  if (header.version() <= kHttp10)
    return bad_request("HTTP/1.0 knows no Transfer-Encoding, expected HTTP/1.1");
  return std::nullopt;
}

}  // namespace

std::optional<RequestViolation> violation_of(const RequestHeader& header) {
  const auto hosts = header.count(http::field::host);
  if (hosts > 1) return bad_request("the request has several Host headers, expected one");
  if (hosts == 0 && header.version() > kHttp10)
    return bad_request("the request has no Host header, expected one");
  if (auto wrong = length_violation(header)) return wrong;
  const std::string_view expected = header[http::field::expect];
  if (!expected.empty() && !beast::iequals(expected, "100-continue")) {
    return RequestViolation{.status = http::status::expectation_failed,
                            .sentence = "the Expect header is not known, expected 100-continue or none"};
  }
  return std::nullopt;
}

bool to_origin_form(RequestHeader& header) {
  const std::string_view target = header.target();
  // "*" is only of OPTIONS, which is refused as a method.
  if (target.starts_with('/') || target == "*") return true;
  const auto url = urls::parse_uri(target);
  if (!url || !url->has_authority() || (url->scheme() != "http" && url->scheme() != "https")) return false;
  const std::string host(url->encoded_authority());
  const std::string_view path = url->encoded_path();
  const std::string_view query = url->encoded_query();
  const std::string origin_form =
      fmt::format("{}{}{}", path.empty() ? "/" : path, url->has_query() ? "?" : "", query);
  header.set(http::field::host, host);
  header.target(origin_form);
  return true;
}

bool waits_for_continue(const RequestHeader& header) {
  return header.version() > kHttp10 && beast::iequals(header[http::field::expect], "100-continue");
}

bool is_websocket_key(std::string_view key) {
  // 16 bytes are 22 digits and two signs of padding; the last digit has two bits.
  constexpr std::size_t kDigits = 22;
  const auto is_digit = [](unsigned char c) { return std::isalnum(c) != 0 || c == '+' || c == '/'; };
  return key.size() == kDigits + 2 && key.ends_with("==") &&
         std::ranges::all_of(key.substr(0, kDigits), is_digit) &&
         std::string_view("AQgw").find(key[kDigits - 1]) != std::string_view::npos;
}

bool accepts_gzip(const RequestHeader& header) {
  for (const auto& [coding, parameters] : http::ext_list(header[http::field::accept_encoding])) {
    if (!beast::iequals(coding, "gzip")) continue;
    const auto weight = std::ranges::find_if(
        parameters, [](const auto& parameter) { return beast::iequals(parameter.first, "q"); });
    // "0", "0." and "0.000" refuse it.
    return weight == parameters.end() || weight->second.find_first_not_of("0.") != std::string_view::npos;
  }
  return false;
}

}  // namespace fanlight
