// SPDX-License-Identifier: Apache-2.0
// 100 000 mutated messages, many connections at once, and half-open connections: the server continues to
// serve, and counts what it refused.
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <memory>
#include <vector>

#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

namespace asio = boost::asio;
namespace websocket = boost::beast::websocket;
using Body = v1::ServerMessage;

/// The quick generator of Numerical Recipes: the same messages in every run.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : state_(seed) {}
  std::uint32_t below(std::uint32_t most) {
    state_ = 1'664'525 * state_ + 1'013'904'223;
    return static_cast<std::uint32_t>((std::uint64_t{state_} * most) >> 32);
  }

 private:
  std::uint32_t state_;
};

std::vector<std::string> seeds() {
  std::vector<v1::ClientMessage> messages(7);
  messages[0].mutable_scene_change()->mutable_scene()->mutable_light()->set_up_mm(3);
  messages[0].mutable_scene_change()->mutable_scene()->mutable_transfer()->set_points("7 #102030 0.25");
  messages[1].mutable_clock_request()->set_client_time_ms(5);
  messages[2].mutable_probe_change()->mutable_settings()->set_sweep_deg(40);
  messages[3].mutable_login()->set_token("fl_12345678_");
  messages[4].mutable_control()->set_wish(v1::ControlRequest::GRANT);
  messages[4].mutable_control()->set_to_session(2);
  messages[5].mutable_stream()->set_codec(v1::StreamRequest::H264);
  messages[5].mutable_stream()->set_width(64);
  messages[6].mutable_depth()->add_pixels()->set_column(7);
  std::vector<std::string> bytes;
  for (const v1::ClientMessage& message : messages) bytes.push_back(message.SerializeAsString());
  return bytes;
}

std::string mutated(std::string bytes, Dice& dice) {
  for (std::uint32_t change = 0; change <= dice.below(4); ++change) {
    const auto at = dice.below(static_cast<std::uint32_t>(bytes.size()));
    switch (dice.below(4)) {
      case 0:
        bytes[at] = static_cast<char>(dice.below(256));
        break;
      case 1:
        bytes.insert(at, 1 + dice.below(8), static_cast<char>(dice.below(256)));
        break;
      case 2:
        if (bytes.size() > 1) bytes.erase(at, 1);
        break;
      default:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << dice.below(8)));
    }
  }
  return bytes;
}

/// A client that sends mutated messages. Several of them share one event loop. It reads at the same time,
/// because the server would otherwise stop reading from it; on the same thread, because a read answers pings.
class Babbler {
 public:
  Babbler(asio::io_context& loop, const asio::ip::tcp::endpoint& server, std::uint32_t seed)
      : socket_(loop), dice_(seed) {
    socket_.next_layer().connect(server);
    socket_.handshake("127.0.0.1", "/stream");
    socket_.binary(true);
    read();
  }

  /// Sends this number of messages, announces the end, and reads until the server has closed the connection.
  void babble(const std::vector<std::string>& all, int messages) {
    if (messages == 0) {
      boost::system::error_code ignored;
      socket_.next_layer().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
      return;
    }
    said_ = mutated(all[dice_.below(static_cast<std::uint32_t>(all.size()))], dice_);
    socket_.async_write(asio::buffer(said_), [this, &all, messages](auto failure, std::size_t) {
      if (failure) {
        not_sent_ = messages;
      } else {
        babble(all, messages - 1);
      }
    });
  }

  /// Number of messages that could not be sent, because the server had ended the session.
  int messages_not_sent() const { return not_sent_; }

 private:
  void read() {
    socket_.async_read(incoming_, [this](auto failure, std::size_t) {
      incoming_.clear();
      if (!failure) read();
    });
  }

  websocket::stream<asio::ip::tcp::socket> socket_;
  Dice dice_;
  std::string said_;
  boost::beast::flat_buffer incoming_;
  int not_sent_ = 0;
};

TEST(Mutated, MessagesLeaveTheServerServing) {
  constexpr int kClients = 50;
  // The thread sanitizer takes ten times as long for each.
#ifdef __SANITIZE_THREAD__
  constexpr int kMessagesEach = 500;
#else
  constexpr int kMessagesEach = 2000;
#endif
  ServerFixture fixture;
  fixture.show(1, 128);
  const auto all = seeds();
  asio::io_context loop;
  std::vector<std::unique_ptr<Babbler>> babblers;
  for (std::uint32_t seed = 0; seed < kClients; ++seed)
    babblers.push_back(std::make_unique<Babbler>(loop, fixture.endpoint(), seed));
  testing::internal::CaptureStderr();
  for (const auto& babbler : babblers) babbler->babble(all, kMessagesEach);
  loop.run();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "")
      << "what a display says wrongly is counted, not logged";
  for (const auto& babbler : babblers)
    EXPECT_EQ(babbler->messages_not_sent(), 0)
        << "a message that cannot be read is no reason to end a session";
  EXPECT_GT(fixture.counters().messages_refused.value(), std::uint64_t{kClients * kMessagesEach / 10});
  TestDisplay after(fixture.endpoint());
  after.next(Body::kHello);
  fixture.show(2, 60);
  while (after.next(Body::kPicture).picture().picture_id() != 2) {
  }
}

TEST(Mutated, StormsAndHalfOpenConnectionsLeaveTheServerServing) {
  ServerFixture fixture(2000);
  asio::io_context loop;
  std::vector<asio::ip::tcp::socket> half_open;
  for (int connection = 0; connection < 600; ++connection) {
    asio::ip::tcp::socket socket(loop);
    socket.connect(fixture.endpoint());
    const std::string begun = "GET /stream HTTP/1.1\r\nHost: localhost\r\n";
    if (connection % 3 > 0) asio::write(socket, asio::buffer(begun.substr(0, 10U * (connection % 5))));
    if (connection % 2 == 0) {
      socket.set_option(asio::socket_base::linger(true, 0));  // a reset
    } else if (half_open.size() < 200) {
      half_open.push_back(std::move(socket));
    }
  }
  TestDisplay client(fixture.endpoint());
  client.next(Body::kHello);
  fixture.show(3, 70);
  EXPECT_EQ(client.next(Body::kPicture).picture().picture_id(), 3U);
}

}  // namespace
}  // namespace fanlight::test
