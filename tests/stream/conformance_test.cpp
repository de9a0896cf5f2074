// SPDX-License-Identifier: Apache-2.0
// Conformance to RFC 6455 (WebSocket), frame by frame over a plain socket. Numbers in parentheses are its
// sections.
#include <gtest/gtest.h>

#include <boost/asio/read.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <optional>
#include <string>

#include "proto/fanlight.pb.h"
#include "tests/support/server_fixture.hpp"

namespace fanlight::test {
namespace {

namespace asio = boost::asio;

enum Opcode : std::uint8_t { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };

struct Frame {
  std::uint8_t opcode = 0;
  bool last = true;
  std::string payload;
};

/// A WebSocket client that sends exactly the given bytes.
class RawClient {
 public:
  explicit RawClient(const ServerFixture& fixture, const std::string& protocol = "") {
    socket_.connect(fixture.endpoint());
    const std::string offered = protocol.empty() ? "" : "Sec-WebSocket-Protocol: " + protocol + "\r\n";
    send(
        "GET /stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: "
        "Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
        offered + "\r\n");
    boost::system::error_code failure;
    const std::size_t bytes = asio::read_until(socket_, asio::dynamic_buffer(incoming_), "\r\n\r\n", failure);
    answer = incoming_.substr(0, bytes);
    incoming_.erase(0, bytes);
  }

  void send(const std::string& bytes) { asio::write(socket_, asio::buffer(bytes)); }

  /// Sends a frame, masked as a client must (5.3) unless `masked` is false.
  void frame(std::uint8_t first_byte, const std::string& payload, bool masked = true) {
    std::string bytes(1, static_cast<char>(first_byte));
    const std::uint8_t mask_bit = masked ? 0x80 : 0;
    if (payload.size() < 126) {
      bytes += static_cast<char>(mask_bit | payload.size());
    } else {
      bytes += static_cast<char>(mask_bit | 126);
      bytes += static_cast<char>(payload.size() >> 8);
      bytes += static_cast<char>(payload.size() & 255);
    }
    const std::string mask = "\x11\x22\x33\x44";
    if (masked) bytes += mask;
    for (std::size_t at = 0; at < payload.size(); ++at) {
      bytes += masked ? static_cast<char>(payload[at] ^ mask[at % 4]) : payload[at];
    }
    send(bytes);
  }

  /// The next frame; empty if the server has closed the connection.
  std::optional<Frame> next() {
    if (!have(2)) return std::nullopt;
    Frame frame{.opcode = static_cast<std::uint8_t>(incoming_[0] & 15), .last = (incoming_[0] & 0x80) != 0};
    std::size_t length = incoming_[1] & 127;
    std::size_t head = 2;
    const std::size_t wide = length == 126 ? 2 : length == 127 ? 8 : 0;
    if (wide > 0) {
      if (!have(2 + wide)) return std::nullopt;
      length = 0;
      for (std::size_t at = 0; at < wide; ++at)
        length = length << 8 | static_cast<std::uint8_t>(incoming_[2 + at]);
      head += wide;
    }
    if (!have(head + length)) return std::nullopt;
    frame.payload = incoming_.substr(head, length);
    incoming_.erase(0, head + length);
    return frame;
  }

  /// The next frame with this opcode; skips others.
  std::optional<Frame> next(Opcode opcode) {
    for (;;) {
      auto frame = next();
      if (!frame || frame->opcode == opcode) return frame;
    }
  }

  /// The code of the next close frame; 0 if the connection ends without one.
  int closed() {
    const auto frame = next(kClose);
    if (!frame || frame->payload.size() < 2) return 0;
    return static_cast<std::uint8_t>(frame->payload[0]) << 8 | static_cast<std::uint8_t>(frame->payload[1]);
  }

  /// Sends a ClockRequest; whether the server answers it.
  bool lives() {
    v1::ClientMessage message;
    message.mutable_clock_request()->set_client_time_ms(4);
    frame(0x80 | kBinary, message.SerializeAsString());
    return clock_reply();
  }

  /// Waits for the answer to clock_request().
  bool clock_reply() {
    for (;;) {
      const auto frame = next(kBinary);
      v1::ServerMessage reply;
      if (!frame || !reply.ParseFromString(frame->payload)) return false;
      if (reply.has_clock_reply()) return reply.clock_reply().client_time_ms() == 4;
    }
  }

  std::string answer;

 private:
  bool have(std::size_t bytes) {
    boost::system::error_code failure;
    if (incoming_.size() < bytes) {
      asio::read(socket_, asio::dynamic_buffer(incoming_), asio::transfer_at_least(bytes - incoming_.size()),
                 failure);
    }
    return incoming_.size() >= bytes;
  }

  asio::io_context loop_;
  asio::ip::tcp::socket socket_{loop_};
  std::string incoming_;
};

std::string clock_request() {
  v1::ClientMessage message;
  message.mutable_clock_request()->set_client_time_ms(4);
  return message.SerializeAsString();
}

TEST(Conformance, AcceptsTheUpgradeAsTheStandardRequires) {
  ServerFixture fixture;
  RawClient client(fixture);
  EXPECT_NE(client.answer.find("101"), std::string::npos);
  EXPECT_NE(client.answer.find("s3pPLMBiTxaQ9kYGzzhZRbK+xOo="), std::string::npos) << "RFC 6455, 1.3";
  EXPECT_EQ(client.answer.find("Sec-WebSocket-Protocol"), std::string::npos) << "the client offered none";
  EXPECT_TRUE(client.lives());
}

TEST(Conformance, ChoosesTheSubprotocol) {
  ServerFixture fixture;
  for (const char* offer : {"fanlight.v2", "fanlight.v9, fanlight.v2", " fanlight.v2 ,other"}) {
    RawClient client(fixture, offer);
    EXPECT_NE(client.answer.find("Sec-WebSocket-Protocol: fanlight.v2\r\n"), std::string::npos) << offer;
  }
  for (const char* offer : {"fanlight.v1", "fanlight.v3,fanlight.v4", "fanlight.v2x", ","}) {
    RawClient client(fixture, offer);
    EXPECT_NE(client.answer.find("HTTP/1.1 400"), std::string::npos) << offer;
  }
}

TEST(Conformance, AcceptsFragmentsWithControlFramesBetweenThem) {
  ServerFixture fixture;
  RawClient client(fixture);
  const std::string whole = clock_request();
  client.frame(kBinary, whole.substr(0, 3));
  client.frame(0x80 | kPing, "are you there");
  client.frame(kContinuation, whole.substr(3, 2));
  client.frame(0x80 | kPong, "no one asked");
  client.frame(kContinuation, "");
  client.frame(0x80 | kContinuation, whole.substr(5));
  const auto pong = client.next(kPong);
  ASSERT_TRUE(pong);
  EXPECT_EQ(pong->payload, "are you there");
  EXPECT_TRUE(client.clock_reply());
}

TEST(Conformance, AcceptsBytesOneByOne) {
  ServerFixture fixture;
  RawClient client(fixture);
  const std::string whole = clock_request();
  std::string bytes = {static_cast<char>(0x82), static_cast<char>(0x80 | whole.size()), 0, 0, 0, 0};
  for (const char byte : bytes + whole) client.send(std::string(1, byte));
  EXPECT_TRUE(client.clock_reply());
}

TEST(Conformance, AnswersACloseWithItsCode) {
  ServerFixture fixture;
  for (const int code : {1000, 1001, 3000, 4999}) {
    RawClient client(fixture);
    client.frame(0x80 | kClose, {static_cast<char>(code >> 8), static_cast<char>(code & 255)});
    EXPECT_EQ(client.closed(), code);
  }
  RawClient client(fixture);
  client.frame(0x80 | kClose, "");
  EXPECT_TRUE(client.next(kClose));
}

TEST(Conformance, ClosesTheConnectionOnProtocolErrors) {
  ServerFixture fixture;
  const auto ended_with = [&](auto send_frames) {
    RawClient client(fixture);
    send_frames(client);
    return client.closed();
  };
  constexpr int kProtocolError = 1002;
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | 0x40 | kBinary, "x"); }), kProtocolError)
      << "RSV1";
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | 0x10 | kBinary, "x"); }), kProtocolError)
      << "RSV3";
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | 3, "x"); }), kProtocolError)
      << "reserved opcode";
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | 11, "x"); }), kProtocolError)
      << "reserved control opcode";
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | kBinary, "x", false); }), kProtocolError)
      << "no mask";
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(kPing, "x"); }), kProtocolError)
      << "a fragmented ping";
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | kPing, std::string(126, 'x')); }),
            kProtocolError)
      << "a ping of over 125 bytes";
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | kContinuation, "x"); }), kProtocolError)
      << "a continuation without a first frame";
  EXPECT_EQ(ended_with([](RawClient& client) {
              client.frame(kBinary, "x");
              client.frame(0x80 | kBinary, "x");
            }),
            kProtocolError)
      << "a message within a message";
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | kClose, "x"); }), kProtocolError)
      << "an incomplete code";
  for (const int code : {0, 999, 1004, 1005, 1006, 1015, 2999}) {
    EXPECT_EQ(ended_with([code](RawClient& client) {
                client.frame(0x80 | kClose, {static_cast<char>(code >> 8), static_cast<char>(code & 255)});
              }),
              kProtocolError)
        << code;
  }
  constexpr int kBadPayload = 1007;
  EXPECT_EQ(ended_with([](RawClient& client) { client.frame(0x80 | kText, "\xC3\x28"); }), kBadPayload)
      << "not UTF-8";
  EXPECT_EQ(ended_with([](RawClient& client) {
              client.frame(kText, "\xF0\x9F");
              client.frame(0x80 | kContinuation, "x");
            }),
            kBadPayload)
      << "not UTF-8 across frames";
  RawClient after(fixture);
  EXPECT_TRUE(after.lives());
}

TEST(Conformance, RefusesMalformedUpgrades) {
  ServerFixture fixture;
  const auto upgrade = [&](const std::string& more) {
    asio::io_context loop;
    asio::ip::tcp::socket socket(loop);
    socket.connect(fixture.endpoint());
    asio::write(
        socket,
        asio::buffer(
            "GET /stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" +
            more + "\r\n"));
    std::string answer;
    boost::system::error_code failure;
    asio::read_until(socket, asio::dynamic_buffer(answer), "\r\n", failure);
    return answer;
  };
  const std::string key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
  EXPECT_NE(upgrade(key).find("HTTP/1.1 400"), std::string::npos) << "no version";
  EXPECT_NE(upgrade("Sec-WebSocket-Version: 13\r\n").find("HTTP/1.1 400"), std::string::npos) << "no key";
  EXPECT_NE(upgrade(key + "Sec-WebSocket-Version: 8\r\n").find("4"), std::string::npos) << "an old version";
  for (const char* const wrong : {"x", "dGhlIHNhbXBsZSBub25jZQ", "dGhlIHNhbXBsZSBub25jZR==",
                                  "dGhlIHNhbXBsZSBub25j!Q==", "dGhlIHNhbXBsZSBub25jZQdGhl"}) {
    const std::string answer =
        upgrade(std::string("Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: ") + wrong + "\r\n");
    EXPECT_NE(answer.find("HTTP/1.1 400"), std::string::npos) << wrong;
  }
}

}  // namespace
}  // namespace fanlight::test
