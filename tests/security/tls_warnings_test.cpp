// SPDX-License-Identifier: Apache-2.0
// Warnings about certificates and keys that can be used, and should not.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <ctime>

#include "server/net/tls_warnings.hpp"
#include "tests/support/made_certificate.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

constexpr long kDayS = 86400;

/// The warnings about a certificate and a key with this mode, as one text.
std::string warned(const MadeCertificate::Options& options, mode_t mode = 0600) {
  const TemporaryFolder folder;
  MadeCertificate(options).write(folder / "c.pem", folder / "k.pem");
  chmod((folder / "k.pem").c_str(), mode);
  std::string all;
  for (const auto& one :
       tls_warnings({.certificate = folder / "c.pem", .key = folder / "k.pem", .client_ca = {}}))
    all += one + "\n";
  return all;
}

TEST(TlsWarnings, TellOfDates) {
  EXPECT_EQ(warned({.to_s = 90 * kDayS}), "");
  EXPECT_NE(warned({.from_s = -2 * kDayS, .to_s = -kDayS}).find("expired on"), std::string::npos);
  EXPECT_NE(warned({.from_s = kDayS, .to_s = 90 * kDayS}).find("not valid before"), std::string::npos);
  EXPECT_NE(warned({.to_s = 3 * kDayS}).find("expires on"), std::string::npos);
}

TEST(TlsWarnings, TellOfTheClientsAuthorityToo) {
  const TemporaryFolder folder;
  MadeCertificate({.to_s = 90 * kDayS}).write(folder / "c.pem", folder / "k.pem");
  chmod((folder / "k.pem").c_str(), 0600);
  MadeCertificate({.from_s = -2 * kDayS, .to_s = -kDayS, .authority = true})
      .write(folder / "a.pem", folder / "ak.pem");
  const auto warnings =
      tls_warnings({.certificate = folder / "c.pem", .key = folder / "k.pem", .client_ca = folder / "a.pem"});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("a.pem"), std::string::npos);
}

TEST(TlsWarnings, TellOfAKeyThatAllMayRead) {
  for (const mode_t mode : {0600U, 0640U, 0400U}) EXPECT_EQ(warned({.to_s = 90 * kDayS}, mode), "") << mode;
  for (const mode_t mode : {0644U, 0666U, 0604U}) {
    EXPECT_NE(warned({.to_s = 90 * kDayS}, mode).find("chmod 600"), std::string::npos) << mode;
  }
}

TEST(CertificateExpires, IsASecondSince1970) {
  const TemporaryFolder folder;
  MadeCertificate({.to_s = 3 * kDayS}).write(folder / "c.pem", folder / "k.pem");
  EXPECT_NEAR(static_cast<double>(certificate_expires_s(folder / "c.pem")),
              static_cast<double>(std::time(nullptr) + 3 * kDayS), 60);
  EXPECT_EQ(certificate_expires_s("/absent"), 0U);
}

TEST(TlsWarnings, SayNothingOfFilesThatAreNotThere) {
  EXPECT_TRUE(tls_warnings({.certificate = "/absent", .key = "/absent", .client_ca = {}}).empty());
}

}  // namespace
}  // namespace fanlight::test
