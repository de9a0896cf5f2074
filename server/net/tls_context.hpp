// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <memory>

#include "proto/base/result.hpp"
#include "server/access/digest.hpp"
#include "server/access/file_version.hpp"

namespace fanlight {

/// The files of a TLS server, all PEM.
struct TlsFiles {
  std::filesystem::path certificate;  ///< of the server, followed by the intermediate ones
  std::filesystem::path key;
  std::filesystem::path client_ca;  ///< authority that signs client certificates; empty: none are requested

  bool empty() const { return certificate.empty(); }
};

/// TLS 1.3, or 1.2 with an AEAD cipher and an ephemeral key (Mozilla's intermediate list without its DHE).
/// A client certificate is optional, because a token is sufficient. Errors: kBadInput with the file.
Result<std::shared_ptr<boost::asio::ssl::context>> make_tls_context(const TlsFiles& files);

/// The versions of the three files; they differ after one of the files was replaced or written.
std::array<FileVersion, 3> file_marks(const TlsFiles& files);

/// SHA-256 over the certificate's DER, as browsers and `openssl x509 -fingerprint -sha256` show it.
Digest fingerprint(const X509* certificate);

}  // namespace fanlight
