// SPDX-License-Identifier: Apache-2.0
// HTTP: the page, the health check, the metrics, and malformed requests.
#include <gtest/gtest.h>

#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <string>

#include "server/net/listen_address.hpp"
#include "tests/support/server_fixture.hpp"

namespace fanlight::test {
namespace {

/// Sends the bytes and returns all that the server sends until it closes the connection. `body` is sent once
/// the server has asked for it.
std::string talk_raw(const ServerFixture& fixture, const std::string& request, const std::string& body = "") {
  boost::asio::io_context loop;
  boost::asio::ip::tcp::socket socket(loop);
  socket.connect(fixture.endpoint());
  boost::asio::write(socket, boost::asio::buffer(request));
  std::string answer;
  boost::system::error_code end;
  if (!body.empty()) {
    boost::asio::read_until(socket, boost::asio::dynamic_buffer(answer), "\r\n\r\n", end);
    boost::asio::write(socket, boost::asio::buffer(body), end);
  }
  boost::asio::read(socket, boost::asio::dynamic_buffer(answer), end);
  return answer;
}

std::string get(const ServerFixture& fixture, const std::string& target) {
  return talk_raw(fixture, "GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
}

TEST(Http, ServesThePage) {
  ServerFixture fixture;
  const std::string page = get(fixture, "/");
  EXPECT_NE(page.find("HTTP/1.1 200"), std::string::npos);
  EXPECT_NE(page.find("text/html"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'"), std::string::npos);
  EXPECT_NE(page.find("id=\"picture\""), std::string::npos);
  EXPECT_NE(get(fixture, "/viewer.js").find("text/javascript"), std::string::npos);
  EXPECT_EQ(get(fixture, "/viewer.js").find("Content-Encoding"), std::string::npos) << "it did not ask";
  EXPECT_NE(get(fixture, "/viewer.css?version=1").find("text/css"), std::string::npos);
  EXPECT_NE(get(fixture, "/favicon.svg").find("image/svg+xml"), std::string::npos);
}

TEST(Http, CompressesThePageForThoseWhoTakeIt) {
  ServerFixture fixture;
  const auto asks = [&](const std::string& codings) {
    return talk_raw(fixture, "GET /viewer.js HTTP/1.1\r\nHost: localhost\r\nAccept-Encoding: " + codings +
                                 "\r\nConnection: close\r\n\r\n");
  };
  const std::size_t whole = get(fixture, "/viewer.js").size();
  for (const char* const taken : {"gzip", "gzip, deflate, br, zstd", "br;q=1.0, GZIP;q=0.5"}) {
    const std::string answer = asks(taken);
    EXPECT_NE(answer.find("Content-Encoding: gzip"), std::string::npos) << taken;
    EXPECT_NE(answer.find("Vary: Accept-Encoding"), std::string::npos);
    EXPECT_LT(answer.size(), whole / 2);
    EXPECT_LT(answer.size(), 250'000U);
    EXPECT_NE(answer.find("\r\n\r\n\x1f\x8b"), std::string::npos) << "the magic bytes of gzip";
  }
  for (const char* const refused : {"", "br", "gzip;q=0", "gzip; q=0.000", "xgzip"})
    EXPECT_EQ(asks(refused).find("Content-Encoding"), std::string::npos) << refused;
}

TEST(Http, ServesHealthAndMetrics) {
  ServerFixture fixture;
  EXPECT_NE(get(fixture, "/healthz")
                .find("ok; source running; picture waiting; The first volume is not complete yet."),
            std::string::npos);
  const std::string metrics = get(fixture, "/metrics");
  for (const char* name :
       {"fanlight_frames_received_total 0", "fanlight_pass1_runs_total 0", "fanlight_volumes_dropped_total 0",
        "fanlight_pictures_skipped_total 0", "fanlight_sessions 0"}) {
    EXPECT_NE(metrics.find(name), std::string::npos) << name;
  }
}

TEST(Http, ReportsAFailedSourceAsUnhealthy) {
  ServerFixture fixture(64, "the probe was disconnected");
  const std::string answer = get(fixture, "/healthz");
  EXPECT_NE(answer.find("HTTP/1.1 503"), std::string::npos);
  EXPECT_NE(answer.find("failing; source the probe was disconnected; picture waiting; The source has failed: "
                        "the probe was disconnected."),
            std::string::npos);
}

TEST(Http, AnswersHeadWithoutABody) {
  ServerFixture fixture;
  const std::string answer =
      talk_raw(fixture, "HEAD / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_NE(answer.find("HTTP/1.1 200"), std::string::npos);
  EXPECT_EQ(answer.substr(answer.size() - 4), "\r\n\r\n");
}

TEST(Http, RefusesUnknownPathsAndMethods) {
  ServerFixture fixture;
  for (const char* target : {"/nothing", "/../etc/passwd", "/index.html/", "//", "*"}) {
    EXPECT_NE(get(fixture, target).find("HTTP/1.1 404"), std::string::npos) << target;
  }
  EXPECT_NE(talk_raw(fixture, "DELETE / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                .find("HTTP/1.1 405"),
            std::string::npos);
  EXPECT_NE(talk_raw(fixture, "GET /stream HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
                .find("HTTP/1.1 404"),
            std::string::npos);
  EXPECT_GE(fixture.counters().requests_refused.value(), 7U);
}

TEST(Http, RefusesHostsThatAreNotLoopback) {
  ServerFixture fixture;
  const auto named = [&](const std::string& host) {
    return talk_raw(fixture, "GET /healthz HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
  };
  for (const char* host :
       {"localhost", "localhost:8080", "127.0.0.1:1", "127.1.2.3", "[::1]", "[::1]:8080"}) {
    EXPECT_NE(named(host).find("HTTP/1.1 200"), std::string::npos) << host;
  }
  for (const char* host :
       {"elsewhere.example", "elsewhere.example:8080", "10.0.0.1", "localhost.example", "[::2]:80", "::"}) {
    EXPECT_NE(named(host).find("HTTP/1.1 421"), std::string::npos) << host;
  }
}

TEST(Http, RefusesMalformedRequests) {
  ServerFixture fixture;
  // Appended: gcc 12 wrongly warns of array bounds for a sum of temporary strings.
  std::string large_header = "GET / HTTP/1.1\r\nX: ";
  large_header.append(20'000, 'x').append("\r\n\r\n");
  for (const std::string& request :
       {std::string("nonsense\r\n\r\n"), std::string("GET / HTTP/1.1\r\nContent-Length: 5\r\n\r\nhello"),
        large_header, std::string("GET / HTTP/9.9\r\n\r\n")}) {
    const std::string answer = talk_raw(fixture, request);
    const auto* const status = request == large_header ? "HTTP/1.1 431" : "HTTP/1.1 400";
    EXPECT_NE(answer.find(status), std::string::npos) << request.substr(0, 40);
    EXPECT_NE(answer.find("expected"), std::string::npos) << request.substr(0, 40);
  }
  EXPECT_NE(get(fixture, "/healthz").find("ok"), std::string::npos);
}

/// Status lines in everything that came: one for each request that was served.
std::size_t answers_in(const std::string& received) {
  std::size_t count = 0;
  for (auto at = received.find("HTTP/1."); at != std::string::npos; at = received.find("HTTP/1.", at + 1))
    ++count;
  return count;
}

TEST(Http, ServesNoBodyAsTheNextRequest) {
  ServerFixture fixture;
  const std::string smuggled = "GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  const std::string chunked = "0\r\n\r\n";
  for (const char* header :
       {"Transfer-Encoding: xchunked", "Transfer-Encoding: identity", "Transfer-Encoding: chunked, identity",
        "Transfer-Encoding: gzip, chunked", "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked",
        "Transfer-Encoding: chunked\r\nContent-Length: 5", "Content-Length: 5\r\nTransfer-Encoding: chunked",
        "Content-Length: 0\r\nContent-Length: 5", "Transfer-Encoding : chunked",
        "Transfer-Encoding:\x0b"
        "chunked"}) {
    std::string request =
        "PATCH /api/scene HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n";
    request.append(header).append("\r\n\r\n").append(chunked).append(smuggled);
    const std::string received = talk_raw(fixture, request);
    EXPECT_EQ(answers_in(received), 1U) << header << "\n" << received;
    EXPECT_NE(received.find("HTTP/1.1 400"), std::string::npos) << header << "\n" << received;
    EXPECT_NE(received.find("Connection: close"), std::string::npos) << header;
  }
}

TEST(Http, TakesAPlainChunkedBody) {
  ServerFixture fixture;
  const std::string received =
      talk_raw(fixture,
               "PATCH /api/scene HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
               "Transfer-Encoding: Chunked\r\nConnection: close\r\n\r\n2\r\n{}\r\n0\r\n\r\n");
  EXPECT_NE(received.find("HTTP/1.1 200"), std::string::npos) << received;
}

TEST(Http, NeedsOneHost) {
  ServerFixture fixture;
  const auto asked = [&](const std::string& head) {
    return talk_raw(fixture, head + "Connection: close\r\n\r\n");
  };
  EXPECT_NE(asked("GET / HTTP/1.1\r\n").find("HTTP/1.1 400"), std::string::npos);
  EXPECT_NE(asked("GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n").find("HTTP/1.1 400"),
            std::string::npos);
  EXPECT_NE(asked("GET / HTTP/1.0\r\n").find(" 200 "), std::string::npos) << "HTTP/1.0 has none";
}

TEST(Http, TakesTargetsInAbsoluteForm) {
  ServerFixture fixture;
  const auto asked = [&](const std::string& target, const char* host) {
    std::string request = "GET ";
    request.append(target).append(" HTTP/1.1\r\nHost: ").append(host);
    return talk_raw(fixture, request.append("\r\nConnection: close\r\n\r\n"));
  };
  EXPECT_NE(asked("http://localhost/healthz", "localhost").find("HTTP/1.1 200"), std::string::npos);
  EXPECT_NE(asked("http://localhost", "localhost").find("text/html"), std::string::npos);
  EXPECT_NE(asked("http://localhost:8080/viewer.css?version=1", "localhost").find("text/css"),
            std::string::npos);
  EXPECT_NE(asked("http://elsewhere.example/", "localhost").find("HTTP/1.1 421"), std::string::npos)
      << "the target's host counts, not the header's";
  EXPECT_NE(asked("ftp://localhost/", "localhost").find("HTTP/1.1 400"), std::string::npos);
  EXPECT_NE(asked("localhost:80", "localhost").find("HTTP/1.1 400"), std::string::npos);
}

TEST(Http, AnswersExpectations) {
  ServerFixture fixture;
  const std::string head =
      "PATCH /api/scene HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
      "Content-Length: 2\r\nConnection: close\r\n";
  const std::string met = talk_raw(fixture, head + "Expect: 100-continue\r\n\r\n", "{}");
  EXPECT_EQ(met.find("HTTP/1.1 100 Continue\r\n\r\n"), 0U) << met;
  EXPECT_NE(met.find("HTTP/1.1 200"), std::string::npos) << met;
  const std::string unknown = talk_raw(fixture, head + "Expect: a-miracle\r\n\r\n{}");
  EXPECT_NE(unknown.find("HTTP/1.1 417"), std::string::npos) << unknown;
}

TEST(Http, SaysWhichMethodsAreAllowed) {
  ServerFixture fixture;
  const auto deleted = [&](const std::string& path) {
    std::string request = "DELETE ";
    return talk_raw(fixture,
                    request.append(path).append(" HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"));
  };
  EXPECT_NE(deleted("/").find("Allow: GET, HEAD\r\n"), std::string::npos);
  EXPECT_NE(deleted("/api/scene").find("Allow: GET, HEAD, PATCH\r\n"), std::string::npos);
  EXPECT_NE(deleted("/api/picture.png").find("Allow: GET, HEAD\r\n"), std::string::npos);
}

TEST(Http, NoAnswerToHeadHasABody) {
  ServerFixture fixture;
  fixture.show(1, 100);
  for (const char* target : {"/", "/nothing", "/api/scene", "/api/picture.png", "/metrics"}) {
    std::string request = "HEAD ";
    request.append(target).append(" HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    const std::string answer = talk_raw(fixture, request);
    EXPECT_EQ(answer.find("\r\n\r\n"), answer.size() - 4) << target << "\n" << answer;
  }
  const std::string refused = talk_raw(fixture, "HEAD / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n");
  EXPECT_EQ(refused.find("\r\n\r\n"), refused.size() - 4) << refused;
}

TEST(ListenAddress, IsParsedOrRefused) {
  EXPECT_EQ(page_url(parse_listen_address("127.0.0.1:8080").value(), false), "http://127.0.0.1:8080/");
  EXPECT_EQ(page_url(parse_listen_address("[::1]:80").value(), false), "http://[::1]:80/");
  EXPECT_EQ(page_url(parse_listen_address("localhost:80").value(), false), "http://127.0.0.1:80/");
  EXPECT_EQ(page_url(parse_listen_address("8080").value(), false), "http://127.0.0.1:8080/");
  for (const char* text : {"", ":", "80x", "65536", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536",
                           "127.0.0.1:-1", "otherhost:80", "127.0.0.1:80x", "300.0.0.1:80", "[::1:80"}) {
    const auto refused = parse_listen_address(text);
    ASSERT_FALSE(refused) << text;
    EXPECT_NE(refused.error().message.find("expected"), std::string::npos);
  }
}

}  // namespace
}  // namespace fanlight::test
