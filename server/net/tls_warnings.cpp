// SPDX-License-Identifier: Apache-2.0
#include "server/net/tls_warnings.hpp"

#include <fmt/format.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <memory>

namespace fanlight {

namespace {

constexpr int kWarnedDays = 14;

struct Release {
  void operator()(std::FILE* file) const { std::fclose(file); }
  void operator()(X509* certificate) const { X509_free(certificate); }
};

/// The first certificate of a PEM file, which is the owner's; null if there is none.
std::unique_ptr<X509, Release> certificate_in(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, Release> file(std::fopen(path.c_str(), "re"));
  if (file == nullptr) return nullptr;
  return std::unique_ptr<X509, Release>(PEM_read_X509(file.get(), nullptr, nullptr, nullptr));
}

std::string time_text(const ASN1_TIME* time) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return "an unknown time";
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02} UTC", parts.tm_year + 1900, parts.tm_mon + 1,
                     parts.tm_mday, parts.tm_hour, parts.tm_min);
}

void warn_of_dates(const std::filesystem::path& path, std::vector<std::string>& warnings) {
  const auto certificate = certificate_in(path);
  if (certificate == nullptr) return;
  const ASN1_TIME* const from = X509_get0_notBefore(certificate.get());
  const ASN1_TIME* const to = X509_get0_notAfter(certificate.get());
  if (X509_cmp_current_time(to) < 0) {
    warnings.push_back(
        fmt::format("{}: the certificate expired on {}, and clients will refuse it; expected "
                    "a new one, which is read while the server runs",
                    path.string(), time_text(to)));
    return;
  }
  if (X509_cmp_current_time(from) > 0) {
    warnings.push_back(
        fmt::format("{}: the certificate is not valid before {}, and clients will refuse it; "
                    "expected the right date on this machine, or another certificate",
                    path.string(), time_text(from)));
  }
  std::time_t soon = std::time(nullptr) + std::time_t{kWarnedDays} * 86400;
  if (X509_cmp_time(to, &soon) < 0) {
    warnings.push_back(fmt::format("{}: the certificate expires on {}, expected a new one before",
                                   path.string(), time_text(to)));
  }
}

}  // namespace

std::vector<std::string> tls_warnings(const TlsFiles& files) {
  std::vector<std::string> warnings;
  for (const auto* path : {&files.certificate, &files.client_ca}) {
    if (!path->empty()) warn_of_dates(*path, warnings);
  }
  struct stat status {};
  if (stat(files.key.c_str(), &status) == 0 && (status.st_mode & (S_IROTH | S_IWOTH)) != 0) {
    warnings.push_back(
        fmt::format("{}: every user of this machine may read or write the private key, expected "
                    "chmod 600",
                    files.key.string()));
  }
  return warnings;
}

std::uint64_t certificate_expires_s(const std::filesystem::path& path) {
  const auto certificate = certificate_in(path);
  std::tm parts{};
  if (certificate == nullptr || ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &parts) != 1) return 0;
  return static_cast<std::uint64_t>(std::max<std::time_t>(timegm(&parts), 0));
}

}  // namespace fanlight
