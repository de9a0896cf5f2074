// SPDX-License-Identifier: Apache-2.0
#include "tests/support/test_display.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <stdexcept>

namespace fanlight::test {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

struct TestDisplay::Socket {
  boost::asio::io_context loop;
  websocket::stream<boost::asio::ip::tcp::socket> stream{loop};
};

TestDisplay::TestDisplay(const boost::asio::ip::tcp::endpoint& endpoint, const std::string& origin,
                         const std::string& from)
    : socket_(std::make_unique<Socket>()) {
  auto& stream = socket_->stream;
  stream.next_layer().open(endpoint.protocol());
  stream.next_layer().bind({boost::asio::ip::make_address(from), 0});
  stream.next_layer().connect(endpoint);
  stream.set_option(websocket::stream_base::decorator([&origin](websocket::request_type& request) {
    if (!origin.empty()) request.set(beast::http::field::origin, origin);
  }));
  stream.read_message_max(64 << 20);
  stream.handshake("127.0.0.1:" + std::to_string(endpoint.port()), "/stream");
}

void TestDisplay::ping() {
  socket_->stream.ping({});
}

TestDisplay::~TestDisplay() = default;
TestDisplay::TestDisplay(TestDisplay&&) noexcept = default;

v1::ServerMessage TestDisplay::next() {
  beast::flat_buffer incoming;
  socket_->stream.read(incoming);
  v1::ServerMessage message;
  if (!message.ParseFromArray(incoming.cdata().data(), static_cast<int>(incoming.size()))) {
    throw std::runtime_error("the server sent a malformed ServerMessage");
  }
  return message;
}

v1::ServerMessage TestDisplay::next(v1::ServerMessage::BodyCase body) {
  for (;;) {
    if (auto message = next(); message.body_case() == body) return message;
  }
}

void TestDisplay::send_bytes(const std::string& bytes, bool binary) {
  socket_->stream.binary(binary);
  socket_->stream.write(boost::asio::buffer(bytes));
}

v1::SceneReply TestDisplay::change(const v1::Scene& scene, std::uint64_t request_id) {
  v1::ClientMessage message;
  message.mutable_scene_change()->set_request_id(request_id);
  *message.mutable_scene_change()->mutable_scene() = scene;
  send(message);
  return next(v1::ServerMessage::kSceneReply).scene_reply();
}

void TestDisplay::close() {
  socket_->stream.close(websocket::close_code::normal);
}

void TestDisplay::close_half() {
  socket_->stream.next_layer().shutdown(boost::asio::ip::tcp::socket::shutdown_send);
}

void TestDisplay::vanish() {
  socket_->stream.next_layer().close();
}

std::uint16_t TestDisplay::close_code() const {
  return socket_->stream.reason().code;
}

}  // namespace fanlight::test
