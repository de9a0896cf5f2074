// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace fanlight::test {

/// An OpenIGTLink server that sends what a test wants. Listens on this machine alone. One client at a time.
class FakeScanner {
 public:
  FakeScanner() {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener_, 4), 0);
    EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
  }
  ~FakeScanner() {
    hang_up();
    ::close(listener_);
  }
  FakeScanner(const FakeScanner&) = delete;
  FakeScanner& operator=(const FakeScanner&) = delete;

  /// "127.0.0.1:PORT"
  std::string place() const { return "127.0.0.1:" + std::to_string(port_); }

  /// Waits for a client, up to five seconds.
  bool accept() {
    pollfd waiting{.fd = listener_, .events = POLLIN, .revents = 0};
    if (poll(&waiting, 1, 5000) <= 0) return false;
    const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    hang_up();  // the one before
    client_ = client;
    return client_ >= 0;
  }

  /// Blocks until the client has taken it. False: it is gone.
  bool send(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes = bytes.subspan(static_cast<std::size_t>(sent));
    }
    return true;
  }

  /// What the client has sent so far, and sends within 200 ms.
  std::vector<std::uint8_t> received() {
    std::vector<std::uint8_t> bytes;
    for (;;) {
      pollfd waiting{.fd = client_, .events = POLLIN, .revents = 0};
      std::uint8_t piece[4096];
      if (poll(&waiting, 1, 200) <= 0) return bytes;
      const ssize_t count = recv(client_, piece, sizeof(piece), 0);
      if (count <= 0) return bytes;
      bytes.insert(bytes.end(), piece, piece + count);
    }
  }

  void hang_up() {
    if (client_ >= 0) ::close(std::exchange(client_, -1));
  }

 private:
  int listener_ = -1;
  int client_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace fanlight::test
