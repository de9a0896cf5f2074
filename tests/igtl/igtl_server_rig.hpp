// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <thread>

#include "server/igtl/igtl_server.hpp"
#include "tests/igtl/test_client.hpp"
#include "tests/support/server_fixture.hpp"

namespace fanlight::test {

/// A server with OpenIGTLink on a free port of this machine.
inline StreamServer::Config with_igtl(Role role = Role::kOperator, std::uint32_t most_messages = 500) {
  IgtlStreams usual;
  usual.set(IgtlStream::kPicture, true);
  usual.set(IgtlStream::kCamera, true);
  return {.igtl = IgtlServer::Config{.endpoint = {boost::asio::ip::make_address("127.0.0.1"), 0},
                                     .usual = usual,
                                     .spacing_mm = 2,
                                     .role = role,
                                     .most_messages = most_messages}};
}

/// Whether it holds within five seconds.
template <typename Holds>
bool soon(Holds holds) {
  for (int i = 0; i < 500 && !holds(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return holds();
}

}  // namespace fanlight::test
