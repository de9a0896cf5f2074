// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/beast/http/fields.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/status.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace fanlight {

/// Why a request must not be served, as the answer to it. The connection is closed after it, because what
/// follows on it may be read in two ways.
struct RequestViolation {
  boost::beast::http::status status = boost::beast::http::status::bad_request;
  std::string sentence;
};

using RequestHeader = boost::beast::http::request_header<boost::beast::http::fields>;

/// Checks the header of a request against RFC 9112, sections 3.2 (Host), 6.1 (Transfer-Encoding) and 6.3, and
/// RFC 9110, section 10.1.1 (Expect), where Beast is more lenient: a proxy before this server may find the
/// end of the request elsewhere than Beast does. Empty: it may be served.
std::optional<RequestViolation> violation_of(const RequestHeader& header);

/// Brings a target in absolute form ("http://host/path") to origin form, with its host as the Host header, as
/// RFC 9112, section 3.2.2 asks. False: it is in neither form.
bool to_origin_form(RequestHeader& header);

/// Whether the client waits for "100 Continue" before it sends the body.
bool waits_for_continue(const RequestHeader& header);

/// Whether this is the key of a WebSocket handshake: 16 bytes in base64 (RFC 6455, section 4.1). Beast does
/// not look at it.
bool is_websocket_key(std::string_view key);

/// Whether the client takes an answer that is compressed with gzip (RFC 9110, section 12.5.3).
bool accepts_gzip(const RequestHeader& header);

}  // namespace fanlight
