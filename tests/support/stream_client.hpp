#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <functional>
#include <stdexcept>
#include <string>

#include "proto/fanlight.pb.h"

namespace fanlight::test {

/// A display that does one thing at a time; throws boost::system::system_error where the server closed.
class StreamClient {
 public:
  explicit StreamClient(const boost::asio::ip::tcp::endpoint& endpoint, const std::string& origin = "") {
    socket_.next_layer().connect(endpoint);
    socket_.set_option(boost::beast::websocket::stream_base::decorator(
        [&origin](boost::beast::websocket::request_type& request) {
          if (!origin.empty()) request.set(boost::beast::http::field::origin, origin);
        }));
    socket_.read_message_max(64 << 20);
    socket_.binary(true);
    socket_.handshake("127.0.0.1:" + std::to_string(endpoint.port()), "/stream");
  }

  v1::ServerMessage next() {
    boost::beast::flat_buffer incoming;
    socket_.read(incoming);
    v1::ServerMessage message;
    if (!message.ParseFromArray(incoming.cdata().data(), static_cast<int>(incoming.size()))) {
      throw std::runtime_error("the server sent what is no ServerMessage");
    }
    return message;
  }

  /// The next message with this body, passing over others.
  v1::ServerMessage next(v1::ServerMessage::BodyCase body) {
    for (;;) {
      if (auto message = next(); message.body_case() == body) return message;
    }
  }

  void send(const v1::ClientMessage& message) { send_bytes(message.SerializeAsString()); }
  void send_bytes(const std::string& bytes, bool binary = true) {
    socket_.binary(binary);
    socket_.write(boost::asio::buffer(bytes));
  }

  /// Sends the change and returns its reply.
  v1::SceneReply change(const v1::Scene& scene, std::uint64_t request_id = 1) {
    v1::ClientMessage message;
    message.mutable_scene_change()->set_request_id(request_id);
    *message.mutable_scene_change()->mutable_scene() = scene;
    send(message);
    return next(v1::ServerMessage::kSceneReply).scene_reply();
  }

  boost::beast::websocket::stream<boost::asio::ip::tcp::socket>& socket() { return socket_; }

 private:
  boost::asio::io_context loop_;
  boost::beast::websocket::stream<boost::asio::ip::tcp::socket> socket_{loop_};
};

}  // namespace fanlight::test
