// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "server/net/tls_context.hpp"

namespace fanlight::test {

/// A certificate with its private key for tests, self-signed or signed by `signer`. P-256. Unless it is an
/// authority, it is valid for 127.0.0.1 and localhost.
class MadeCertificate {
 public:
  struct Options {
    std::string name = "fanlight test";
    long from_s = -3600;     ///< begin of validity, relative to now
    long to_s = 90 * 86400;  ///< end of validity, relative to now
    bool authority = false;
  };

  explicit MadeCertificate(const Options& options, const MadeCertificate* signer = nullptr) {
    static long serial = 1;
    key_.reset(EVP_EC_gen("P-256"));
    certificate_.reset(X509_new());
    X509* const certificate = certificate_.get();
    X509_set_version(certificate, 2);
    ASN1_INTEGER_set(X509_get_serialNumber(certificate), serial++);
    X509_gmtime_adj(X509_getm_notBefore(certificate), options.from_s);
    X509_gmtime_adj(X509_getm_notAfter(certificate), options.to_s);
    X509_set_pubkey(certificate, key_.get());
    X509_NAME* const subject = X509_get_subject_name(certificate);
    X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>(options.name.c_str()), -1, -1, 0);
    const MadeCertificate& issuer = signer != nullptr ? *signer : *this;
    X509_set_issuer_name(certificate, X509_get_subject_name(issuer.certificate_.get()));
    extend(issuer, NID_basic_constraints, options.authority ? "critical,CA:TRUE" : "critical,CA:FALSE");
    if (!options.authority) extend(issuer, NID_subject_alt_name, "IP:127.0.0.1,DNS:localhost");
    if (X509_sign(certificate, issuer.key_.get(), EVP_sha256()) == 0) std::abort();
  }

  /// Writes both as PEM files.
  void write(const std::filesystem::path& certificate, const std::filesystem::path& key) const {
    const auto file = [](const std::filesystem::path& path) {
      return std::unique_ptr<std::FILE, int (*)(std::FILE*)>(std::fopen(path.c_str(), "w"), std::fclose);
    };
    PEM_write_X509(file(certificate).get(), certificate_.get());
    PEM_write_PrivateKey(file(key).get(), key_.get(), nullptr, nullptr, 0, nullptr, nullptr);
    std::filesystem::permissions(key, std::filesystem::perms(0600));
  }

  Digest fingerprint() const { return fanlight::fingerprint(certificate_.get()); }

 private:
  void extend(const MadeCertificate& issuer, int kind, const char* value) {
    X509V3_CTX context;
    X509V3_set_ctx(&context, issuer.certificate_.get(), certificate_.get(), nullptr, nullptr, 0);
    X509_EXTENSION* const extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value);
    X509_add_ext(certificate_.get(), extension, -1);
    X509_EXTENSION_free(extension);
  }

  struct Release {
    void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
    void operator()(X509* certificate) const { X509_free(certificate); }
  };
  std::unique_ptr<EVP_PKEY, Release> key_;
  std::unique_ptr<X509, Release> certificate_;
};

}  // namespace fanlight::test
