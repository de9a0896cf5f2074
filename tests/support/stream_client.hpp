#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <memory>
#include <string>

#include "proto/fanlight.pb.h"

namespace fanlight::test {

/// A display that does one thing at a time; throws boost::system::system_error where the server closed.
class StreamClient {
 public:
  explicit StreamClient(const boost::asio::ip::tcp::endpoint& endpoint, const std::string& origin = "",
                        const std::string& from = "127.0.0.1");
  ~StreamClient();
  StreamClient(StreamClient&&) noexcept;

  v1::ServerMessage next();

  /// The next message with this body, passing over others.
  v1::ServerMessage next(v1::ServerMessage::BodyCase body);

  void send(const v1::ClientMessage& message) { send_bytes(message.SerializeAsString()); }
  void send_bytes(const std::string& bytes, bool binary = true);

  /// Sends the change and returns its reply.
  v1::SceneReply change(const v1::Scene& scene, std::uint64_t request_id = 1);

  /// Says good-bye.
  void close();
  /// Sends no more, and reads nothing either.
  void close_half();
  /// Goes without a word.
  void vanish();
  /// Of the server's close frame.
  std::uint16_t close_code() const;

 private:
  struct Socket;
  std::unique_ptr<Socket> socket_;
};

}  // namespace fanlight::test
