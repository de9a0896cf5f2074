// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

/// The other sites whose pages may embed the server's page, read its answers and open its stream. By default
/// there is none.
class AllowedOrigins {
 public:
  /// Parses "https://ward.example,http://127.0.0.1:3000": schemes http and https, without paths. Error,
  /// kInvalidArgument.
  static Result<AllowedOrigins> parse(std::string_view text);

  bool empty() const { return origins_.empty(); }

  /// Whether an Origin header names one of them (RFC 6454, section 7).
  bool has(std::string_view origin) const;

  /// Whether a Referer header is the address of a page of one of them.
  bool has_page(std::string_view referer) const;

  /// For frame-ancestors of a Content-Security-Policy: separated by spaces, or "'none'".
  std::string sources() const;

 private:
  std::vector<std::string> origins_;  // as browsers write them
};

}  // namespace fanlight
