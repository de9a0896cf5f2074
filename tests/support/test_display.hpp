// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "proto/fanlight.pb.h"

namespace fanlight::test {

/// A display with blocking calls. They throw boost::system::system_error if the server has closed the
/// connection. One thread.
class TestDisplay {
 public:
  /// `origin`: header of the upgrade request, as of a browser; empty: none. `from`: local address.
  explicit TestDisplay(const boost::asio::ip::tcp::endpoint& endpoint, const std::string& origin = "",
                       const std::string& from = "127.0.0.1");
  ~TestDisplay();
  TestDisplay(TestDisplay&&) noexcept;

  /// The next message.
  v1::ServerMessage next();

  /// The next message with this body; skips others.
  v1::ServerMessage next(v1::ServerMessage::BodyCase body);

  void send(const v1::ClientMessage& message) { send_bytes(message.SerializeAsString()); }
  void send_bytes(const std::string& bytes, bool binary = true);

  /// Sends the change and returns its reply.
  v1::SceneReply change(const v1::Scene& scene, std::uint64_t request_id = 1);

  /// Sends a ping of the WebSocket.
  void ping();
  /// Closes with a close frame.
  void close();
  /// Closes the sending half of the TCP connection.
  void close_half();
  /// Closes the TCP connection without a close frame.
  void vanish();
  /// The code of the close frame of the server.
  std::uint16_t close_code() const;

 private:
  struct Socket;
  std::unique_ptr<Socket> socket_;
};

}  // namespace fanlight::test
