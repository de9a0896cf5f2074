// SPDX-License-Identifier: Apache-2.0
// Who gets a place on the server, and who loses it.
#include "server/net/connection_limit.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "server/net/connect_rate.hpp"

namespace fanlight::test {
namespace {

boost::asio::ip::address address(const std::string& text) {
  return boost::asio::ip::make_address(text);
}

/// The nth host of a network with many.
boost::asio::ip::address host(unsigned number) {
  return address("192.0." + std::to_string(2 + number / 256) + "." + std::to_string(number % 256));
}

TEST(ConnectionLimit, OneHostCannotUseAllPlaces) {
  ConnectionLimit limit(16, 2);
  auto first = limit.take(host(7));
  const auto second = limit.take(host(7));
  EXPECT_TRUE(first && second);
  EXPECT_FALSE(limit.take(host(7)));
  first.reset();
  EXPECT_TRUE(limit.take(host(7))) << "a place was given back";
}

TEST(ConnectionLimit, LoopbackWhereAProxyMayRunMayUseAll) {
  ConnectionLimit limit(8, 2);
  std::vector<ConnectionPermit> permits;
  while (auto permit = limit.take(address("127.0.0.1"))) {
    permit->authenticated();
    permits.push_back(std::move(*permit));
  }
  EXPECT_EQ(permits.size(), 8U);
}

TEST(ConnectionLimit, AnonymousClientsOnLoopbackGiveWayToANewOne) {
  ConnectionLimit limit(8, 2);
  std::vector<std::optional<ConnectionPermit>> idle(7);
  std::vector<std::size_t> closed;
  for (std::size_t number = 0; number < idle.size(); ++number) {
    auto taken = limit.take(address("127.0.0.1"));
    ASSERT_TRUE(taken);
    idle[number].emplace(std::move(*taken));
    idle[number]->on_eviction([&, number] {
      closed.push_back(number);
      idle[number].reset();
    });
  }
  const auto newer = limit.take(address("127.0.0.1"));
  EXPECT_TRUE(newer);
  EXPECT_EQ(closed, (std::vector<std::size_t>{0}));
}

TEST(ConnectionLimit, CountsIpv6ByNetwork) {
  EXPECT_EQ(ConnectionLimit::host_of(address("2001:db8:1:2:3::4")), "2001:db8:1:2::/64");
  EXPECT_EQ(ConnectionLimit::host_of(address("::ffff:192.0.2.1")), "192.0.2.1");
  EXPECT_EQ(ConnectionLimit::host_of(address("::1")), "");
  EXPECT_EQ(ConnectionLimit::host_of(address("::ffff:127.0.0.1")), "");
  ConnectionLimit limit(16, 2);
  const auto first = limit.take(address("2001:db8:1:2::1"));
  const auto second = limit.take(address("2001:db8:1:2::2"));
  EXPECT_TRUE(first && second);
  EXPECT_FALSE(limit.take(address("2001:db8:1:2:ffff::3"))) << "the same customer";
  EXPECT_TRUE(limit.take(address("2001:db8:1:3::1")));
}

TEST(ConnectionLimit, TheOldestAnonymousClientMakesRoomForANewOne) {
  ConnectionLimit limit(8, 8);  // six places for anonymous clients
  std::vector<std::optional<ConnectionPermit>> anonymous;
  std::vector<unsigned> closed;
  for (unsigned number = 0; number < 6; ++number) {
    anonymous.push_back(limit.take(host(number)));
    ASSERT_TRUE(anonymous.back());
    anonymous.back()->on_eviction([&closed, number] { closed.push_back(number); });
  }
  anonymous[0]->authenticated();  // by now known
  auto seventh = limit.take(host(20));
  ASSERT_TRUE(seventh);
  EXPECT_TRUE(closed.empty()) << "the one that logged in left its place to another anonymous client";
  auto eighth = limit.take(host(21));
  ASSERT_TRUE(eighth);
  EXPECT_EQ(closed, (std::vector<unsigned>{1})) << "the oldest that did not log in";
  EXPECT_EQ(limit.evicted(), 1U);
  EXPECT_FALSE(limit.take(host(22))) << "all places are taken until the closed one has ended";
  anonymous[1].reset();
  EXPECT_TRUE(limit.take(host(22)));
}

TEST(ConnectionLimit, AnonymousClientsLeaveAQuarterForLoopback) {
  ConnectionLimit limit(8, 8);
  std::vector<ConnectionPermit> anonymous;
  // None of them can be closed yet: their handshakes have not begun.
  while (auto permit = limit.take(host(static_cast<unsigned>(anonymous.size()))))
    anonymous.push_back(std::move(*permit));
  EXPECT_EQ(anonymous.size(), 6U);
  EXPECT_TRUE(limit.take(address("127.0.0.1")));
}

TEST(ConnectionLimit, UnknownHostsLeaveAQuarterForHostsThatAreKnown) {
  ConnectionLimit limit(8, 8);
  limit.take(host(100))->authenticated();
  std::vector<ConnectionPermit> unknown;
  while (auto permit = limit.take(host(static_cast<unsigned>(unknown.size()))))
    unknown.push_back(std::move(*permit));
  EXPECT_EQ(unknown.size(), 6U);
  EXPECT_TRUE(limit.take(host(100)));
}

TEST(ConnectionLimit, AnonymousClientsGiveWayWhereAuthenticatedOnesHaveTheRest) {
  ConnectionLimit limit(16, 16);
  std::vector<ConnectionPermit> known;
  for (unsigned number = 0; number < 6; ++number) {
    known.push_back(*limit.take(host(100)));
    known.back().authenticated();
  }
  std::vector<std::optional<ConnectionPermit>> idle(10);  // less than their share of 12
  for (unsigned number = 0; number < idle.size(); ++number) {
    auto taken = limit.take(host(number));
    ASSERT_TRUE(taken);
    idle[number].emplace(std::move(*taken));
    idle[number]->on_eviction([&idle, number] { idle[number].reset(); });
  }
  const auto newer = limit.take(host(50));
  const auto local = limit.take(address("127.0.0.1"));
  EXPECT_TRUE(newer && local);
  EXPECT_FALSE(idle[0] || idle[1]) << "the oldest";
  EXPECT_TRUE(idle[2]);
}

TEST(ConnectRate, PacesAllAndEachHost) {
  ConnectRate rate;
  for (std::size_t taken = 0; taken < ConnectRate::kAHostASecond; ++taken)
    EXPECT_TRUE(rate.take("192.0.2.1"));
  EXPECT_FALSE(rate.take("192.0.2.1"));
  EXPECT_TRUE(rate.take("192.0.2.2"));
  while (rate.may_accept()) EXPECT_TRUE(rate.take("")) << "loopback has no share of its own";
  rate.refill();
  EXPECT_TRUE(rate.may_accept());
  EXPECT_TRUE(rate.take("192.0.2.1"));
}

}  // namespace
}  // namespace fanlight::test
