#include "server/connection.hpp"

#include <openssl/ssl.h>

#include "server/tls_context.hpp"

namespace fanlight {

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
