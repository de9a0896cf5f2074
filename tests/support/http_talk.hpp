// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <cstdlib>
#include <string>

#include "tests/support/server_fixture.hpp"

namespace fanlight::test {

/// An HTTP response.
struct Answer {
  int status = 0;
  std::string head;
  std::string body;
};

/// One request on a connection of its own.
inline Answer talk(const ServerFixture& fixture, const std::string& method, const std::string& target,
                   const std::string& body = "", const std::string& type = "application/json") {
  boost::asio::io_context loop;
  boost::asio::ip::tcp::socket socket(loop);
  socket.connect(fixture.endpoint());
  const std::string more =
      body.empty() ? ""
                   : "Content-Type: " + type + "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
  boost::system::error_code end;
  boost::asio::write(
      socket,
      boost::asio::buffer(method + " " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" +
                          more + "\r\n" + body),
      end);
  std::string text;
  boost::asio::read(socket, boost::asio::dynamic_buffer(text), end);
  const std::size_t split = text.find("\r\n\r\n");
  return {text.size() > 9 ? std::atoi(text.c_str() + 9) : 0, text.substr(0, split), text.substr(split + 4)};
}

}  // namespace fanlight::test
