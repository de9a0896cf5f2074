// One in control at a time, at the desk alone.
#include <gtest/gtest.h>

#include "server/control_desk.hpp"

namespace fanlight::test {
namespace {

const ControlDesk::Party kAnna{.session = 1, .name = "Anna"};
const ControlDesk::Party kBen{.session = 2, .name = "Ben"};
const ControlDesk::Party kCleo{.session = 3, .name = "Cleo"};

TEST(ControlDesk, GoesToTheFirstWhoChangesSomething) {
  ControlDesk desk;
  EXPECT_FALSE(desk.use(kAnna, Role::kViewer, 0));
  EXPECT_TRUE(desk.use(kAnna, Role::kOperator, 0));
  EXPECT_TRUE(desk.holds(1));
  const auto other = desk.use(kBen, Role::kAdmin, 0);
  ASSERT_FALSE(other) << "an admin takes over, and does not slip in";
  EXPECT_NE(other.error().message.find("Anna"), std::string::npos);
  EXPECT_TRUE(desk.use(kAnna, Role::kOperator, 1));
}

TEST(ControlDesk, IsAskedForGrantedAndReleased) {
  ControlDesk desk;
  EXPECT_TRUE(desk.ask(kAnna, Role::kOperator, 0).value());
  EXPECT_FALSE(desk.ask(kBen, Role::kOperator, 0).value());
  EXPECT_FALSE(desk.ask(kBen, Role::kOperator, 0).value()) << "twice is once";
  EXPECT_FALSE(desk.ask(kCleo, Role::kOperator, 0).value());
  ASSERT_EQ(desk.state().asking.size(), 2U);
  EXPECT_FALSE(desk.grant(2, 3, 0)) << "not his to give";
  EXPECT_FALSE(desk.grant(1, 9, 0)) << "nobody of that number asks";
  EXPECT_TRUE(desk.grant(1, 3, 0));
  EXPECT_TRUE(desk.holds(3));
  ASSERT_EQ(desk.state().asking.size(), 1U);
  EXPECT_TRUE(desk.release(3, 0));
  EXPECT_TRUE(desk.holds(2)) << "who asked first";
  EXPECT_FALSE(desk.release(1, 0)) << "neither has it nor asks";
  EXPECT_TRUE(desk.release(2, 0));
  EXPECT_EQ(desk.state().holder.session, 0U);
  EXPECT_FALSE(desk.ask(kAnna, Role::kViewer, 0));
}

TEST(ControlDesk, IsTakenOverByAnAdminAlone) {
  ControlDesk desk;
  ASSERT_TRUE(desk.use(kAnna, Role::kOperator, 0));
  EXPECT_FALSE(desk.take_over(kBen, Role::kOperator, 0));
  EXPECT_TRUE(desk.take_over(kBen, Role::kAdmin, 0));
  EXPECT_TRUE(desk.holds(2));
}

TEST(ControlDesk, LapsesAfterSilence) {
  ControlDesk desk(1000);
  ASSERT_TRUE(desk.use(kAnna, Role::kOperator, 0));
  ASSERT_FALSE(desk.ask(kBen, Role::kOperator, 10).value());
  EXPECT_FALSE(desk.lapse(999));
  ASSERT_TRUE(desk.keep(1, 999));
  EXPECT_FALSE(desk.keep(2, 999));
  EXPECT_FALSE(desk.lapse(1998));
  EXPECT_TRUE(desk.lapse(1999));
  EXPECT_TRUE(desk.holds(2)) << "and goes to who asks";
  EXPECT_TRUE(desk.lapse(2999));
  EXPECT_EQ(desk.state().holder.session, 0U);
  EXPECT_FALSE(desk.lapse(9999)) << "nothing left to lapse";
}

TEST(ControlDesk, GoesWithItsSession) {
  ControlDesk desk;
  ASSERT_TRUE(desk.use(kAnna, Role::kOperator, 0));
  ASSERT_FALSE(desk.ask(kBen, Role::kOperator, 0).value());
  ASSERT_FALSE(desk.ask(kCleo, Role::kOperator, 0).value());
  EXPECT_TRUE(desk.left(2, 0));
  EXPECT_FALSE(desk.left(9, 0));
  EXPECT_TRUE(desk.left(1, 0));
  EXPECT_TRUE(desk.holds(3));
}

TEST(ControlDesk, HasRoomForSoManyWhoAsk) {
  ControlDesk desk;
  ASSERT_TRUE(desk.use(kAnna, Role::kOperator, 0));
  bool refused = false;
  for (std::uint64_t session = 2; session < 1000; ++session) {
    refused |= !desk.ask({.session = session, .name = "x"}, Role::kOperator, 0);
  }
  EXPECT_TRUE(refused);
  EXPECT_LE(desk.state().asking.size(), 64U);
}

}  // namespace
}  // namespace fanlight::test
