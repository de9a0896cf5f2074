// SPDX-License-Identifier: Apache-2.0
// TLS on the wire: accepted and refused versions and ciphers, and certificates of clients and of the server.
#include <gtest/gtest.h>

#include <boost/asio/read.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>

#include "tests/support/tls_server_fixture.hpp"

namespace fanlight::test {
namespace {

namespace asio = boost::asio;
namespace ssl = boost::asio::ssl;

/// Performs the handshake with this configuration, sends the request, and returns the answer or the error.
std::string https(const TlsServerFixture& guarded, ssl::context& context, const std::string& request) {
  asio::io_context loop;
  ssl::stream<asio::ip::tcp::socket> stream(loop, context);
  boost::system::error_code failure;
  stream.lowest_layer().connect(const_cast<TlsServerFixture&>(guarded).fixture().endpoint());
  stream.handshake(ssl::stream_base::client, failure);
  if (failure) return "handshake: " + failure.message();
  asio::write(stream, asio::buffer(request), failure);
  std::string answer;
  asio::read(stream, asio::dynamic_buffer(answer), failure);
  return answer.empty() ? failure.message() : answer;
}

std::string get(const std::string& target, const std::string& more = "") {
  return "GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + more + "\r\n";
}

ssl::context client() {
  return ssl::context(ssl::context::tls_client);
}

TEST(Tls, GuardsTheScriptsDoorAndTheMetrics) {
  TlsServerFixture guarded;
  auto context = client();
  EXPECT_NE(https(guarded, context, get("/")).find("HTTP/1.1 200"), std::string::npos)
      << "the page, to log in on";
  EXPECT_NE(https(guarded, context, get("/healthz")).find("HTTP/1.1 200"), std::string::npos);
  for (const char* target : {"/metrics", "/api/scene", "/api/picture.png"}) {
    EXPECT_NE(https(guarded, context, get(target)).find("HTTP/1.1 401"), std::string::npos) << target;
    const std::string with = "Authorization: Bearer " + guarded.token(Role::kViewer).text + "\r\n";
    EXPECT_EQ(https(guarded, context, get(target, with)).find("HTTP/1.1 401"), std::string::npos) << target;
    const std::string lower = "Authorization: bearer " + guarded.token(Role::kViewer).text + "\r\n";
    EXPECT_EQ(https(guarded, context, get(target, lower)).find("HTTP/1.1 401"), std::string::npos) << target;
  }
}

TEST(Tls, TellsBrowsersToStayWithTlsOnlyWhereAskedFor) {
  TlsServerFixture plain;
  auto context = client();
  EXPECT_EQ(https(plain, context, get("/")).find("Strict-Transport-Security"), std::string::npos);
  TlsServerFixture strict(60'000, true);
  EXPECT_NE(https(strict, context, get("/")).find("Strict-Transport-Security"), std::string::npos);
}

TEST(Tls, AnUnlistedCertificateGetsThePageToLogInOn) {
  TlsServerFixture guarded;
  const MadeCertificate other({.name = "signed, not listed"}, &guarded.authority());
  other.write(guarded.file("other.pem"), guarded.file("other.key"));
  auto context = client();
  context.use_certificate_chain_file(guarded.file("other.pem"));
  context.use_private_key_file(guarded.file("other.key"), ssl::context::pem);
  for (const char* target : {"/", "/viewer.js", "/healthz"})
    EXPECT_NE(https(guarded, context, get(target)).find(" 200 "), std::string::npos) << target;
  EXPECT_NE(https(guarded, context, get("/api/scene")).find(" 401 "), std::string::npos);
  const auto with_token = fanlight::StreamClient::connect({.url = guarded.url(),
                                                           .token = guarded.token(Role::kViewer).text,
                                                           .server_ca = guarded.file("server.pem"),
                                                           .certificate = guarded.file("other.pem"),
                                                           .key = guarded.file("other.key")});
  EXPECT_TRUE(with_token) << with_token.error().message;
}

TEST(Tls, AViewersScriptMayReadAndNotChange) {
  TlsServerFixture guarded;
  auto context = client();
  const auto patch = [&](Role role) {
    const std::string body = R"({"light": {"up_mm": 33}})";
    return https(guarded, context,
                 "PATCH /api/scene HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: "
                 "application/json\r\n"
                 "Authorization: Bearer " +
                     guarded.token(role).text + "\r\nContent-Length: " + std::to_string(body.size()) +
                     "\r\n\r\n" + body);
  };
  EXPECT_NE(patch(Role::kViewer).find("HTTP/1.1 403"), std::string::npos);
  EXPECT_FALSE(guarded.fixture().has_scene());
  EXPECT_NE(patch(Role::kOperator).find("\"up_mm\": 33"), std::string::npos);
  EXPECT_EQ(guarded.fixture().next_scene().scene.light.up_mm, 33);
}

TEST(Tls, SpeaksNothingOlderAndNothingWeaker) {
  TlsServerFixture guarded;
  const auto handshake = [&](int least, int most, const char* ciphers) {
    auto context = client();
    SSL_CTX_set_security_level(context.native_handle(),
                               0);  // so that the server refuses, and not the library of the test
    SSL_CTX_set_min_proto_version(context.native_handle(), least);
    SSL_CTX_set_max_proto_version(context.native_handle(), most);
    if (ciphers != nullptr) SSL_CTX_set_cipher_list(context.native_handle(), ciphers);
    return https(guarded, context, get("/healthz"));
  };
  EXPECT_NE(handshake(TLS1_3_VERSION, TLS1_3_VERSION, nullptr).find("HTTP/1.1 200"), std::string::npos);
  EXPECT_NE(handshake(TLS1_2_VERSION, TLS1_2_VERSION, "ECDHE-ECDSA-AES128-GCM-SHA256").find("HTTP/1.1 200"),
            std::string::npos);
  for (const int version : {TLS1_VERSION, TLS1_1_VERSION}) {
    EXPECT_NE(handshake(version, version, nullptr).find("handshake"), std::string::npos) << version;
  }
  for (const char* weak : {"ECDHE-ECDSA-AES128-SHA", "ECDHE-ECDSA-AES128-SHA256", "AES128-GCM-SHA256"}) {
    EXPECT_NE(handshake(TLS1_2_VERSION, TLS1_2_VERSION, weak).find("handshake"), std::string::npos) << weak;
  }
}

TEST(Tls, AClientsCertificateTakesThePlaceOfAToken) {
  TlsServerFixture guarded;
  const StreamClient::Config console{.url = guarded.url(),
                                     .server_ca = guarded.file("server.pem"),
                                     .certificate = guarded.file("client.pem"),
                                     .key = guarded.file("client.key")};
  const auto known = fanlight::StreamClient::connect(console);
  ASSERT_TRUE(known) << known.error().message;
  EXPECT_EQ((*known)->hello().name(), "console");
  EXPECT_EQ((*known)->hello().role(), v1::OPERATOR);
}

TEST(Tls, RefusesCertificatesThatAreUnknownForeignOrExpired) {
  TlsServerFixture guarded;
  const auto come = [&](const MadeCertificate& certificate) {
    certificate.write(guarded.file("other.pem"), guarded.file("other.key"));
    const auto client = fanlight::StreamClient::connect({.url = guarded.url(),
                                                         .server_ca = guarded.file("server.pem"),
                                                         .certificate = guarded.file("other.pem"),
                                                         .key = guarded.file("other.key")});
    return client ? "" : client.error().message;
  };
  EXPECT_NE(come(MadeCertificate({.name = "signed, not listed"}, &guarded.authority())).find("does not open"),
            std::string::npos);
  EXPECT_NE(come(MadeCertificate({.name = "its own"})), "");
  EXPECT_NE(come(MadeCertificate({.name = "old", .from_s = -7200, .to_s = -3600}, &guarded.authority())), "");
  EXPECT_EQ(guarded.audited("login", 3).size(), 3U);
  for (int tries = 0; tries < 100 && guarded.fixture().counters().handshakes_failed.value() < 2; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(guarded.fixture().counters().handshakes_failed.value(), 2U);
  EXPECT_EQ(guarded.fixture().counters().logins_refused.value(), 1U) << "the others did not get so far";
}

TEST(Tls, TakesARenewedCertificateWithoutARestart) {
  TlsServerFixture guarded;
  const auto before = guarded.come_in(Role::kViewer);
  const MadeCertificate renewed({.name = "renewed"});
  renewed.write(guarded.file("server.pem"), guarded.file("server.key"));
  ASSERT_EQ(guarded.audited("certificates_read").size(), 1U);
  EXPECT_TRUE(fanlight::StreamClient::connect(guarded.display(Role::kViewer)))
      << "which trusts the new one alone";
  EXPECT_TRUE(before->next()) << "who is in stays in";
  std::ofstream(guarded.file("server.pem")) << "nonsense";
  EXPECT_NE(guarded.audited("certificates_read", 2).back()["result"], "done");
  EXPECT_TRUE(before->next());
}

TEST(Tls, SurvivesNonsense) {
  TlsServerFixture guarded;
  asio::io_context loop;
  std::vector<asio::ip::tcp::socket> half_open;
  std::uint32_t state = 1;
  for (int round = 0; round < 200; ++round) {
    asio::ip::tcp::socket socket(loop);
    socket.connect(guarded.fixture().endpoint());
    std::string bytes(static_cast<std::size_t>(round), '\0');
    for (char& byte : bytes) byte = static_cast<char>((state = 1'664'525 * state + 1'013'904'223) >> 24);
    if (round % 3 == 0 && bytes.size() > 3)
      bytes.replace(0, 3, "\x16\x03\x01");  // the beginning of a ClientHello
    boost::system::error_code ignored;
    asio::write(socket, asio::buffer(bytes), ignored);
    if (round % 2 == 0) half_open.push_back(std::move(socket));
  }
  EXPECT_TRUE(fanlight::StreamClient::connect(guarded.display(Role::kViewer)));
}

TEST(Tls, APageOfAnotherSiteIsRefusedAndAudited) {
  TlsServerFixture guarded;
  auto context = client();
  const std::string with = "Authorization: Bearer " + guarded.token(Role::kAdmin).text +
                           "\r\nOrigin: https://elsewhere.example\r\n";
  EXPECT_NE(https(guarded, context, get("/api/scene", with)).find("HTTP/1.1 403"), std::string::npos);
  EXPECT_EQ(guarded.audited("request").size(), 1U);
}

TEST(Tls, StartsWithoutAFileOfItsOnlyToSayWhich) {
  StreamServer::Config config;
  config.tls = {.certificate = "/nowhere.pem", .key = "/nowhere.key"};
  try {
    ServerFixture fixture(config);
    FAIL();
  } catch (const std::runtime_error& refused) {
    EXPECT_NE(std::string(refused.what()).find("/nowhere.pem"), std::string::npos);
  }
}

}  // namespace
}  // namespace fanlight::test
