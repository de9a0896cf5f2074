// SPDX-License-Identifier: Apache-2.0
#include "server/net/connection.hpp"

#include <openssl/ssl.h>

#include <boost/asio/ssl/host_name_verification.hpp>

#include "server/net/tls_context.hpp"

namespace fanlight {

namespace beast = boost::beast;

void Connection::async_handshake(boost::asio::ssl::stream_base::handshake_type end, Done done) {
  std::get<Tls>(stream_).async_handshake(end, std::move(done));
}

void Connection::expect_host(const std::string& host) {
  Tls& tls = std::get<Tls>(stream_);
  tls.set_verify_callback(boost::asio::ssl::host_name_verification(host));
  SSL_set_tlsext_host_name(tls.native_handle(), host.c_str());
}

void Connection::read_some(const MutableBuffers& buffers, Moved moved) {
  if (is_tls()) return std::get<Tls>(stream_).async_read_some(buffers, std::move(moved));
  next_layer().async_read_some(buffers, std::move(moved));
}

void Connection::write_some(const ConstBuffers& buffers, Moved moved) {
  if (is_tls()) return std::get<Tls>(stream_).async_write_some(buffers, std::move(moved));
  next_layer().async_write_some(buffers, std::move(moved));
}

void Connection::async_shutdown(Done done) {
  if (is_tls()) return std::get<Tls>(stream_).async_shutdown(std::move(done));
  beast::error_code failure;
  next_layer().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, failure);
  done(failure);
}

void Connection::tear_down(beast::role_type role, Done done) {
  using beast::websocket::async_teardown;
  if (is_tls()) {
    async_teardown(role, std::get<Tls>(stream_), std::move(done));
  } else {
    async_teardown(role, next_layer().socket(), std::move(done));
  }
}

std::optional<Digest> Connection::client_fingerprint() {
  if (!is_tls()) return std::nullopt;
  X509* const certificate = SSL_get1_peer_certificate(std::get<Tls>(stream_).native_handle());
  if (certificate == nullptr) return std::nullopt;
  const Digest digest = fingerprint(certificate);
  X509_free(certificate);
  return digest;
}

std::string Connection::certificate_trouble() {
  if (!is_tls()) return {};
  const long result = SSL_get_verify_result(std::get<Tls>(stream_).native_handle());
  return result == X509_V_OK ? "" : X509_verify_cert_error_string(result);
}

}  // namespace fanlight
