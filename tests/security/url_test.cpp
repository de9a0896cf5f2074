// SPDX-License-Identifier: Apache-2.0
// The URL of a server, and the Host and Origin headers of a request.
#include <gtest/gtest.h>

#include "server/client/server_url.hpp"
#include "server/net/allowed_origins.hpp"
#include "server/net/request_host.hpp"

namespace fanlight::test {
namespace {

/// "tls host port", or the sentence of the error.
std::string parsed(const std::string& text) {
  const auto url = parse_server_url(text);
  if (!url) return url.error().message;
  return std::string(url->tls ? "tls " : "plain ") + url->host + " " + url->port;
}

TEST(ServerUrl, HasASchemeAHostAndAPort) {
  EXPECT_EQ(parsed("http://127.0.0.1:8080/"), "plain 127.0.0.1 8080");
  EXPECT_EQ(parsed("http://127.0.0.1:8080"), "plain 127.0.0.1 8080");
  EXPECT_EQ(parsed("ws://console-2.example/stream"), "plain console-2.example 80");
  EXPECT_EQ(parsed("https://console_2/a/b:7?c=d://e#f"), "tls console_2 443");
  EXPECT_EQ(parsed("wss://localhost:08443"), "tls localhost 8443");
  EXPECT_EQ(parsed("HTTPS://Console"), "tls Console 443");
}

TEST(ServerUrl, HasAnIpv6AddressInBrackets) {
  EXPECT_EQ(parsed("http://[::1]:8080/"), "plain ::1 8080");
  EXPECT_EQ(parsed("https://[2001:db8::7]"), "tls 2001:db8::7 443");
  EXPECT_EQ(parsed("http://[::ffff:127.0.0.1]:1/"), "plain ::ffff:127.0.0.1 1");
  EXPECT_EQ(parsed("http://[fe80::1%eth0]:8080/a%20b"), "plain fe80::1%eth0 8080");
  EXPECT_EQ(parse_server_url("http://[::1]").value().host_and_port(), "[::1]:80");
  EXPECT_EQ(parse_server_url("http://localhost").value().host_and_port(), "localhost:80");
}

TEST(ServerUrl, NeedsNoScheme) {
  EXPECT_EQ(parse_server_url("127.0.0.1:9000").value().host_and_port(), "127.0.0.1:9000");
  EXPECT_EQ(parse_server_url("scanner").value().host_and_port(), "scanner:8080") << "the server's usual port";
  EXPECT_EQ(parse_server_url("[::1]").value().host_and_port(), "[::1]:8080");
  EXPECT_EQ(parse_server_url("9000").value().host_and_port(), "127.0.0.1:9000") << "a port of this machine";
  EXPECT_FALSE(parse_server_url("scanner").value().tls);
}

TEST(ServerUrl, IsRefusedWithItsTextInTheSentence) {
  for (const std::string text : {"",
                                 "ftp://localhost",
                                 "http:",
                                 "http://",
                                 "http:///",
                                 "http://:8080",
                                 "0",
                                 "65536",
                                 "http://localhost:",
                                 "http://localhost:port",
                                 "http://localhost:-1",
                                 "http://localhost:0",
                                 "http://localhost:65536",
                                 "http://localhost:4294967377",
                                 "http://me@localhost",
                                 "http://me:secret@localhost",
                                 "http://::1",
                                 "http://[::1",
                                 "http://[::1]8080",
                                 "http://[::g]",
                                 "http://[1]",
                                 "http://[host%eth0]",
                                 "http://local host",
                                 " http://localhost",
                                 "http://localhost%",
                                 "http://\xc3\xa4"}) {
    EXPECT_EQ(parsed(text), text + " is no address of a server, expected one such as http://127.0.0.1:8080");
  }
}

TEST(RequestHost, IsLoopbackUnderAnyPort) {
  for (const char* host :
       {"localhost", "localhost:8080", "127.0.0.1", "127.0.0.1:1", "127.3.2.1:8080", "[::1]", "[::1]:65535",
        "LOCALHOST:8080", "LocalHost", "localhost.", "localhost.:8080"}) {
    EXPECT_TRUE(is_loopback_host(host)) << host;
  }
  for (const char* host :
       {"example.com", "example.com:8080", "localhost.example.com", "127.0.0.1.example.com:8080", "10.0.0.1",
        "[::2]:8080", "me@localhost", "localhost:8080:8080", "localhost/", "[localhost]", "127.0.0.1:port",
        "127.0.0.1 ", ""}) {
    EXPECT_FALSE(is_loopback_host(host)) << host;
  }
}

TEST(RequestHost, IsTheOneOfTheOrigin) {
  EXPECT_TRUE(is_origin_of_host("http://localhost:8080", "localhost:8080", false));
  EXPECT_TRUE(is_origin_of_host("https://console", "console", true));
  EXPECT_TRUE(is_origin_of_host("https://console", "console", false)) << "behind a proxy that ends TLS";
  EXPECT_FALSE(is_origin_of_host("http://console", "console", true));
  EXPECT_TRUE(is_origin_of_host("http://[::1]:8080", "[::1]:8080", false));
  for (const char* origin :
       {"", "null", "localhost:8080", "http://localhost", "http://localhost:8081", "http://localhost:8080/",
        "http://localhost:8080?a", "http://localhost:8080#a", "http://evil.example",
        "http://evil.example/localhost:8080", "http:localhost:8080", "http://evil.example@localhost:8080",
        "://localhost:8080"}) {
    EXPECT_FALSE(is_origin_of_host(origin, "localhost:8080", false)) << origin;
  }
}

TEST(AllowedOrigins, AreAsBrowsersWriteThem) {
  const auto allowed =
      AllowedOrigins::parse("https://Ward.example:443, http://127.0.0.1:3000,https://[2001:db8::7]:8443");
  ASSERT_TRUE(allowed) << allowed.error().message;
  EXPECT_EQ(allowed->sources(), "https://ward.example http://127.0.0.1:3000 https://[2001:db8::7]:8443");
  EXPECT_TRUE(allowed->has("https://ward.example"));
  EXPECT_TRUE(allowed->has_page("https://ward.example/a/b?c#d"));
  EXPECT_TRUE(allowed->has_page("http://127.0.0.1:3000/"));
  for (const char* other :
       {"", "null", "*", "http://ward.example", "https://ward.example:444",
        "https://ward.example.evil.example", "https://evil.example", "https://ward.example@evil.example",
        "https://a.ward.example", "http://127.0.0.1", "http://127.0.0.1:30000"}) {
    EXPECT_FALSE(allowed->has(other)) << other;
    EXPECT_FALSE(allowed->has_page(std::string(other) + "/https://ward.example")) << other;
  }
}

TEST(AllowedOrigins, AreNoneByDefaultAndNeverAll) {
  const auto none = AllowedOrigins::parse("");
  ASSERT_TRUE(none);
  EXPECT_EQ(none->sources(), "'none'");
  EXPECT_FALSE(none->has(""));
  EXPECT_FALSE(none->has_page("https://ward.example/"));
  for (const char* wrong :
       {"*", "ward.example", "https://", "https://ward.example/", "https://ward.example/page", "file:///a",
        "null", "https://ward.example?a", "https://ward.example#a", "https://me@ward.example",
        "https://*.example/", "https://a.example,,https://b.example", "https://a.example;b", "https://a b",
        "javascript:alert(1)"}) {
    EXPECT_FALSE(AllowedOrigins::parse(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace fanlight::test
