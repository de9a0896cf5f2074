#pragma once

#include <array>
#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <memory>

#include "proto/result.hpp"
#include "server/digest.hpp"
#include "server/file_mark.hpp"

namespace fanlight {

/// The files from which a TLS server is made, all PEM.
struct TlsFiles {
  std::filesystem::path certificate;  ///< the server's, followed by those between it and its root
  std::filesystem::path key;
  std::filesystem::path client_ca;  ///< who signs clients' certificates; empty: none are asked for

  bool empty() const { return certificate.empty(); }
};

/// TLS 1.3, or 1.2 with an AEAD cipher and an ephemeral key (Mozilla's intermediate list without its DHE).
/// Clients may show a certificate, and must not: a token will do. Errors: kBadInput with the file.
Result<std::shared_ptr<boost::asio::ssl::context>> make_tls_context(const TlsFiles& files);

/// Others where one of the files was replaced or written.
std::array<FileMark, 3> file_marks(const TlsFiles& files);

/// SHA-256 over the certificate's DER, as browsers and `openssl x509 -fingerprint -sha256` show it.
Digest fingerprint(const X509* certificate);

}  // namespace fanlight
