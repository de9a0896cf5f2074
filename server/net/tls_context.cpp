// SPDX-License-Identifier: Apache-2.0
#include "server/net/tls_context.hpp"

#include <fmt/format.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <algorithm>

namespace fanlight {

namespace ssl = boost::asio::ssl;

namespace {

constexpr const char* kCiphersOfTls12 =
    "ECDHE-ECDSA-AES128-GCM-SHA256:ECDHE-RSA-AES128-GCM-SHA256:ECDHE-ECDSA-AES256-GCM-SHA384:"
    "ECDHE-RSA-AES256-GCM-SHA384:ECDHE-ECDSA-CHACHA20-POLY1305:ECDHE-RSA-CHACHA20-POLY1305";

Error bad_file(const std::filesystem::path& path, const char* expected,
               const boost::system::error_code& why) {
  return {ErrorCode::kBadInput,
          fmt::format("{}: it cannot be used ({}), expected {}", path.string(), why.message(), expected)};
}

}  // namespace

Result<std::shared_ptr<ssl::context>> make_tls_context(const TlsFiles& files) {
  auto context = std::make_shared<ssl::context>(ssl::context::tls_server);
  boost::system::error_code failure;
  context->use_certificate_chain_file(files.certificate.string(), failure);
  if (failure) return bad_file(files.certificate, "a certificate in PEM", failure);
  context->use_private_key_file(files.key.string(), ssl::context::pem, failure);
  if (failure)
    return bad_file(files.key, "the certificate's private key in PEM, without a password", failure);
  if (!files.client_ca.empty()) {
    context->load_verify_file(files.client_ca.string(), failure);
    if (failure) return bad_file(files.client_ca, "certificates in PEM", failure);
    SSL_CTX_set_client_CA_list(context->native_handle(), SSL_load_client_CA_file(files.client_ca.c_str()));
    context->set_verify_mode(ssl::verify_peer);
  }
  SSL_CTX* const handle = context->native_handle();
  SSL_CTX_set_min_proto_version(handle, TLS1_2_VERSION);
  SSL_CTX_set_cipher_list(handle, kCiphersOfTls12);
  SSL_CTX_set1_groups_list(handle, "X25519:P-256:P-384");
  SSL_CTX_set_options(handle, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION |
                                  SSL_OP_CIPHER_SERVER_PREFERENCE | SSL_OP_NO_TICKET);
  SSL_CTX_set_session_cache_mode(handle, SSL_SESS_CACHE_OFF);
  return context;
}

std::array<FileVersion, 3> file_marks(const TlsFiles& files) {
  return {file_version(files.certificate), file_version(files.key), file_version(files.client_ca)};
}

Digest fingerprint(const X509* certificate) {
  Digest digest{};
  unsigned int bytes = digest.size();
  X509_digest(certificate, EVP_sha256(), digest.data(), &bytes);
  return digest;
}

}  // namespace fanlight
