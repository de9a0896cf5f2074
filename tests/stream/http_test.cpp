// The server's HTTP side: the page, health, metrics, and requests that nobody should send.
#include <gtest/gtest.h>

#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <string>

#include "server/listen_address.hpp"
#include "tests/support/fake_house.hpp"

namespace fanlight::test {
namespace {

/// Sends the bytes, reads until the server closes or a whole answer with Content-Length is there.
std::string talk(const FakeHouse& house, const std::string& request) {
  boost::asio::io_context loop;
  boost::asio::ip::tcp::socket socket(loop);
  socket.connect(house.endpoint());
  boost::asio::write(socket, boost::asio::buffer(request));
  std::string answer;
  boost::system::error_code end;
  boost::asio::read(socket, boost::asio::dynamic_buffer(answer), end);
  return answer;
}

std::string get(const FakeHouse& house, const std::string& target) {
  return talk(house, "GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
}

TEST(Http, ServesThePage) {
  FakeHouse house;
  const std::string page = get(house, "/");
  EXPECT_NE(page.find("HTTP/1.1 200"), std::string::npos);
  EXPECT_NE(page.find("text/html"), std::string::npos);
  EXPECT_NE(page.find("Content-Security-Policy: default-src 'none'"), std::string::npos);
  EXPECT_NE(page.find("id=\"picture\""), std::string::npos);
  EXPECT_NE(get(house, "/viewer.js").find("text/javascript"), std::string::npos);
  EXPECT_NE(get(house, "/viewer.css?version=1").find("text/css"), std::string::npos);
  EXPECT_NE(get(house, "/favicon.svg").find("image/svg+xml"), std::string::npos);
}

TEST(Http, TellsHealthAndMetrics) {
  FakeHouse house;
  EXPECT_NE(get(house, "/healthz").find("ok; source running"), std::string::npos);
  const std::string metrics = get(house, "/metrics");
  for (const char* name :
       {"fanlight_frames_received_total 0", "fanlight_pass1_runs_total 0", "fanlight_volumes_dropped_total 0",
        "fanlight_pictures_skipped_total 0", "fanlight_sessions 0"}) {
    EXPECT_NE(metrics.find(name), std::string::npos) << name;
  }
}

TEST(Http, IsUnwellWhereTheSourceFailed) {
  FakeHouse house(64, "the probe is gone");
  const std::string answer = get(house, "/healthz");
  EXPECT_NE(answer.find("HTTP/1.1 503"), std::string::npos);
  EXPECT_NE(answer.find("failing; source the probe is gone"), std::string::npos);
}

TEST(Http, AnswersAHeadWithoutABody) {
  FakeHouse house;
  const std::string answer = talk(house, "HEAD / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_NE(answer.find("200"), std::string::npos);
  EXPECT_EQ(answer.substr(answer.size() - 4), "\r\n\r\n");
}

TEST(Http, RefusesWhatIsNotThereOrNotAllowed) {
  FakeHouse house;
  for (const char* target : {"/nothing", "/../etc/passwd", "/index.html/", "//", "*"}) {
    EXPECT_NE(get(house, target).find("404"), std::string::npos) << target;
  }
  EXPECT_NE(talk(house, "DELETE / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").find("405"),
            std::string::npos);
  EXPECT_NE(talk(house, "GET /stream HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").find("404"),
            std::string::npos);
  EXPECT_GE(house.counters().requests_refused.value(), 7U);
}

TEST(Http, RefusesANameThatIsNotLoopback) {
  FakeHouse house;
  const auto named = [&](const std::string& host) {
    return talk(house, "GET /healthz HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
  };
  for (const char* host :
       {"localhost", "localhost:8080", "127.0.0.1:1", "127.1.2.3", "[::1]", "[::1]:8080"}) {
    EXPECT_NE(named(host).find("200"), std::string::npos) << host;
  }
  for (const char* host :
       {"elsewhere.example", "elsewhere.example:8080", "10.0.0.1", "localhost.example", "[::2]:80", "::"}) {
    EXPECT_NE(named(host).find("421"), std::string::npos) << host;
  }
}

TEST(Http, RefusesWhatIsNoRequest) {
  FakeHouse house;
  for (const std::string& request :
       {std::string("nonsense\r\n\r\n"), std::string("GET / HTTP/1.1\r\nContent-Length: 5\r\n\r\nhello"),
        "GET / HTTP/1.1\r\nX: " + std::string(20'000, 'x') + "\r\n\r\n",
        std::string("GET / HTTP/9.9\r\n\r\n")}) {
    const std::string answer = talk(house, request);
    EXPECT_NE(answer.find("400"), std::string::npos) << request.substr(0, 40);
    EXPECT_NE(answer.find("expected"), std::string::npos) << request.substr(0, 40);
  }
  EXPECT_NE(get(house, "/healthz").find("ok"), std::string::npos);
}

TEST(ListenAddress, IsReadOrRefused) {
  EXPECT_EQ(page_url(parse_listen_address("127.0.0.1:8080").value(), false), "http://127.0.0.1:8080/");
  EXPECT_EQ(page_url(parse_listen_address("[::1]:80").value(), false), "http://[::1]:80/");
  for (const char* text : {"", ":", "8080", "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:-1",
                           "localhost:80", "127.0.0.1:80x", "300.0.0.1:80", "[::1:80"}) {
    const auto refused = parse_listen_address(text);
    ASSERT_FALSE(refused) << text;
    EXPECT_NE(refused.error().message.find("expected"), std::string::npos);
  }
}

}  // namespace
}  // namespace fanlight::test
