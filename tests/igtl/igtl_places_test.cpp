// SPDX-License-Identifier: Apache-2.0
// Who may be a client of the OpenIGTLink server, and for how long.
#include <array>
#include <memory>
#include <vector>

#include "tests/igtl/igtl_server_rig.hpp"

namespace fanlight::test {
namespace igtl_places_tests {

StreamServer::Config with_places(std::size_t places, IgtlSession::Patience patience = {}) {
  StreamServer::Config config = with_igtl();
  config.igtl->usual = {};
  config.igtl->most_clients = places;
  config.igtl->patience = patience;
  return config;
}

TEST(IgtlPlaces, TheOldestClientThatSentNothingGivesWay) {
  ServerFixture server(with_places(16));
  std::vector<std::unique_ptr<TestClient>> silent;
  TestClient speaking(server.igtl_port());
  ASSERT_TRUE(speaking.ask("GET_STATUS", ""));
  ASSERT_TRUE(speaking.next_of("STATUS"));
  ASSERT_TRUE(speaking.next_of("STATUS")) << "one at its begin, and the answer";
  for (int i = 0; i < 15; ++i) {
    silent.push_back(std::make_unique<TestClient>(server.igtl_port()));
    ASSERT_TRUE(silent.back()->next_of("STATUS"));
  }
  ASSERT_TRUE(soon([&] { return server.counters().igtl_clients_evicted.value() == 1; }));
  silent.front()->next(2000);
  EXPECT_TRUE(silent.front()->closed());
  ASSERT_TRUE(speaking.ask("GET_STATUS", ""));
  EXPECT_TRUE(speaking.next_of("STATUS"));
  TestClient newer(server.igtl_port());
  EXPECT_TRUE(newer.next_of("STATUS"));
  EXPECT_EQ(server.counters().igtl_clients_refused.value(), 0U);
}

TEST(IgtlPlaces, AClientIsRefusedWhereAllHaveSentAMessage) {
  ServerFixture server(with_places(8));
  std::vector<std::unique_ptr<TestClient>> clients;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::make_unique<TestClient>(server.igtl_port()));
    ASSERT_TRUE(clients.back()->ask("GET_CAPABIL", ""));
    ASSERT_TRUE(clients.back()->next_of("CAPABILITY"));
  }
  TestClient ninth(server.igtl_port());
  ninth.next(2000);
  EXPECT_TRUE(ninth.closed());
  EXPECT_EQ(server.counters().igtl_clients_refused.value(), 1U);
  EXPECT_EQ(server.counters().igtl_clients_evicted.value(), 0U);
}

TEST(IgtlPlaces, AHeadThatIsNeverWholeEndsTheConnection) {
  ServerFixture server(with_places(8, {.head_s = 1, .idle_s = 600}));
  TestClient slow(server.igtl_port());
  TestClient other(server.igtl_port());
  const std::array<std::uint8_t, 2> begin = {0, 1};  // of version 1
  ASSERT_TRUE(slow.send(begin));
  ASSERT_TRUE(soon([&] { return server.counters().igtl_clients_timed_out.value() == 1; }));
  while (slow.next(2000)) {
  }
  EXPECT_TRUE(slow.closed());
  ASSERT_TRUE(other.ask("GET_CAPABIL", ""));
  EXPECT_TRUE(other.next_of("CAPABILITY"));
}

TEST(IgtlPlaces, AnIdleClientThatSentNothingIsDisconnected) {
  ServerFixture server(with_places(8, {.head_s = 10, .idle_s = 1}));
  TestClient speaking(server.igtl_port());
  ASSERT_TRUE(speaking.ask("GET_CAPABIL", ""));
  TestClient idle(server.igtl_port());
  ASSERT_TRUE(soon([&] { return server.counters().igtl_clients_timed_out.value() == 1; }));
  while (idle.next(2000)) {
  }
  EXPECT_TRUE(idle.closed());
  EXPECT_TRUE(speaking.next_of("CAPABILITY"));
  EXPECT_FALSE(speaking.closed());
}

}  // namespace igtl_places_tests
}  // namespace fanlight::test
