// SPDX-License-Identifier: Apache-2.0
// At most one session holds control: the logic without a server.
#include <gtest/gtest.h>

#include "server/access/control_lease.hpp"

namespace fanlight::test {
namespace {

const ControlLease::Party kAnna{.session = 1, .name = "Anna"};
const ControlLease::Party kBen{.session = 2, .name = "Ben"};
const ControlLease::Party kCleo{.session = 3, .name = "Cleo"};

TEST(ControlLease, GoesToTheFirstWhoChangesSomething) {
  ControlLease lease;
  EXPECT_TRUE(lease.may_change(2));
  EXPECT_TRUE(lease.use(kAnna, 0));
  EXPECT_TRUE(lease.may_change(1));
  EXPECT_FALSE(lease.may_change(2));
  EXPECT_FALSE(lease.may_change(0)) << "a script";
  EXPECT_TRUE(lease.holds(1));
  const auto other = lease.use(kBen, 0);
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("Anna"), std::string::npos);
  EXPECT_TRUE(lease.use(kAnna, 1));
}

TEST(ControlLease, IsAskedForGrantedAndReleased) {
  ControlLease lease;
  EXPECT_TRUE(lease.ask(kAnna, 0).value());
  EXPECT_FALSE(lease.ask(kBen, 0).value());
  EXPECT_FALSE(lease.ask(kBen, 0).value()) << "twice is once";
  EXPECT_FALSE(lease.ask(kCleo, 0).value());
  ASSERT_EQ(lease.state().asking.size(), 2U);
  EXPECT_FALSE(lease.grant(2, 3, 0)) << "not his to give";
  EXPECT_FALSE(lease.grant(1, 9, 0)) << "no one of that number asks";
  EXPECT_TRUE(lease.grant(1, 3, 0));
  EXPECT_TRUE(lease.holds(3));
  ASSERT_EQ(lease.state().asking.size(), 1U);
  EXPECT_TRUE(lease.release(3, 0));
  EXPECT_TRUE(lease.holds(2)) << "who asked first";
  EXPECT_FALSE(lease.release(1, 0)) << "neither has it nor asks";
  EXPECT_TRUE(lease.release(2, 0));
  EXPECT_EQ(lease.state().holder.session, 0U);
}

TEST(ControlLease, IsTakenOver) {
  ControlLease lease;
  ASSERT_TRUE(lease.use(kAnna, 0));
  lease.take_over(kBen, 0);
  EXPECT_TRUE(lease.holds(2));
}

TEST(ControlLease, LapsesAfterSilence) {
  ControlLease lease(1000);
  ASSERT_TRUE(lease.use(kAnna, 0));
  ASSERT_FALSE(lease.ask(kBen, 10).value());
  EXPECT_FALSE(lease.expire(999));
  ASSERT_TRUE(lease.keep(1, 999));
  EXPECT_FALSE(lease.keep(2, 999));
  EXPECT_FALSE(lease.expire(1998));
  EXPECT_TRUE(lease.expire(1999));
  EXPECT_TRUE(lease.holds(2)) << "and goes to who asks";
  EXPECT_TRUE(lease.expire(2999));
  EXPECT_EQ(lease.state().holder.session, 0U);
  EXPECT_FALSE(lease.expire(9999)) << "nothing left to lapse";
}

TEST(ControlLease, GoesWithItsSession) {
  ControlLease lease;
  ASSERT_TRUE(lease.use(kAnna, 0));
  ASSERT_FALSE(lease.ask(kBen, 0).value());
  ASSERT_FALSE(lease.ask(kCleo, 0).value());
  EXPECT_TRUE(lease.left(2, 0));
  EXPECT_FALSE(lease.left(9, 0));
  EXPECT_TRUE(lease.left(1, 0));
  EXPECT_TRUE(lease.holds(3));
}

TEST(ControlLease, HasRoomForSoManyWhoAsk) {
  ControlLease lease;
  ASSERT_TRUE(lease.use(kAnna, 0));
  bool refused = false;
  for (std::uint64_t session = 2; session < 1000; ++session) {
    refused |= !lease.ask({.session = session, .name = "x"}, 0);
  }
  EXPECT_TRUE(refused);
  EXPECT_LE(lease.state().asking.size(), 64U);
}

}  // namespace
}  // namespace fanlight::test
