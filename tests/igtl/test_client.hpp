// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/igtl/message_reader.hpp"
#include "proto/igtl/message_writer.hpp"
#include "proto/igtl/opened_message.hpp"

namespace fanlight::test {

/// A message that a client got.
struct GotMessage {
  igtl::MessageHead head;
  std::vector<std::uint8_t> body;

  igtl::OpenedMessage opened() const { return igtl::open_message(head, body); }
  std::string_view type() const { return head.type.view(); }
  std::string_view device() const { return head.device.view(); }
};

/// An OpenIGTLink client, as a test wants it.
class TestClient {
 public:
  explicit TestClient(std::uint16_t port, int receive_bytes = 0) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_bytes > 0) setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof(receive_bytes));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  }
  ~TestClient() { ::close(socket_); }
  TestClient(const TestClient&) = delete;
  TestClient& operator=(const TestClient&) = delete;

  bool send(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
    }
    return true;
  }
  /// A query without content.
  bool ask(std::string_view type, std::string_view device,
           igtl::HeadVersion version = igtl::HeadVersion::kOne) {
    writer_.begin({.type = igtl::TypeName(type), .device = igtl::DeviceName(device), .version = version});
    return send(writer_.finish());
  }
  igtl::MessageWriter& writer() { return writer_; }

  /// The next message; nullopt: none came within the time, or the server has closed the connection.
  std::optional<GotMessage> next(int most_ms = 5000) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(most_ms);
    for (;;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
      pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
      if (left.count() <= 0 || poll(&waiting, 1, static_cast<int>(left.count())) <= 0) return std::nullopt;
      const auto room = reader_.room();
      const ssize_t bytes = recv(socket_, room.data(), room.size(), 0);
      if (bytes <= 0) {
        closed_ = true;
        return std::nullopt;
      }
      if (reader_.filled(static_cast<std::size_t>(bytes)) == igtl::MessageReader::Event::kMessage)
        return GotMessage{reader_.head(), {reader_.body().begin(), reader_.body().end()}};
    }
  }
  /// The next message of a type; others are passed over.
  std::optional<GotMessage> next_of(std::string_view type, std::string_view device = {}) {
    for (int i = 0; i < 50; ++i) {
      auto message = next();
      if (!message) return std::nullopt;
      if (message->type() == type && (device.empty() || message->device() == device)) return message;
    }
    return std::nullopt;
  }
  bool closed() const { return closed_; }

 private:
  int socket_;
  bool closed_ = false;
  igtl::MessageReader reader_{1 << 24, 1 << 24};
  igtl::MessageWriter writer_;
};

}  // namespace fanlight::test
