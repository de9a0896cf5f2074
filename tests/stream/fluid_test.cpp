// SPDX-License-Identifier: Apache-2.0
// Requests to measure fluid at /stream, with the test in the renderer's place.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "server/state/fluid_desk.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {

namespace {

using Body = v1::ServerMessage;

v1::ClientMessage fluid_at(double x_mm, std::uint64_t volume_id, std::uint64_t request_id) {
  v1::ClientMessage message;
  v1::FluidRequest& request = *message.mutable_fluid();
  request.set_request_id(request_id);
  request.set_volume_id(volume_id);
  request.set_x_mm(x_mm);
  return message;
}

/// Returns once the server has taken what the display has sent.
void wait_until_taken(TestDisplay& display) {
  v1::ClientMessage clock;
  clock.mutable_clock_request();
  display.send(clock);
  display.next(Body::kClockReply);
}

/// As the render thread: the display is frozen on this volume. Returns once a display knows.
void freeze(ServerFixture& fixture, TestDisplay& display, std::uint64_t volume_id) {
  fixture.report_cine({.state = CineStatus::State::kFrozen, .volumes = 1, .volume_id = volume_id});
  while (display.next(Body::kCine).cine().volume_id() != volume_id) {
  }
}

}  // namespace

TEST(FluidOfTheStream, MeasuresFluidInTheVolumeOnShowOneRegionAfterTheOther) {
  ServerFixture fixture;
  TestDisplay first(fixture.endpoint());
  TestDisplay second(fixture.endpoint());
  freeze(fixture, first, 7);
  first.send(fluid_at(1000, 7, 1));
  wait_until_taken(first);
  second.send(fluid_at(-1, 7, 2));
  fixture.answer_fluid(7);
  const v1::FluidReply found = first.next(Body::kFluidReply).fluid_reply();
  EXPECT_EQ(found.request_id(), 1U);
  EXPECT_EQ(found.found().volume_mm3(), 1000);
  EXPECT_EQ(found.found().volume_id(), 7U);
  fixture.answer_fluid(7);
  const v1::FluidReply none = second.next(Body::kFluidReply).fluid_reply();
  EXPECT_EQ(none.request_id(), 2U);
  EXPECT_EQ(none.refused().message(), "this point is not in fluid");

  // The renderer shows another volume by then.
  first.send(fluid_at(1000, 7, 3));
  fixture.answer_fluid(8);
  EXPECT_NE(first.next(Body::kFluidReply).fluid_reply().refused().message().find("another volume"),
            std::string::npos);
  first.send(fluid_at(1000, 7, 4));
  fixture.answer_volume_order(nullptr);
  EXPECT_NE(first.next(Body::kFluidReply).fluid_reply().refused().message().find("no volume"),
            std::string::npos);
}

TEST(FluidOfTheStream, RefusesToMeasureFluidAtNoPlaceOrForACrowd) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  display.send(fluid_at(1, 7, 1));
  EXPECT_NE(display.next(Body::kFluidReply).fluid_reply().refused().message().find("not frozen"),
            std::string::npos);
  freeze(fixture, display, 7);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double x_mm : {nan, 1e9, -std::numeric_limits<double>::infinity()}) {
    display.send(fluid_at(x_mm, 7, 1));
    EXPECT_NE(display.next(Body::kFluidReply).fluid_reply().refused().message().find("expected at most"),
              std::string::npos);
  }
  v1::ClientMessage shifted = fluid_at(1, 7, 1);
  shifted.mutable_fluid()->set_border_db(3.5);
  display.send(shifted);
  EXPECT_NE(display.next(Body::kFluidReply).fluid_reply().refused().message().find("expected -12 to 3"),
            std::string::npos);
  EXPECT_FALSE(fixture.has_volume_order());

  std::vector<std::unique_ptr<TestDisplay>> crowd;
  for (std::size_t count = 0; count < FluidDesk::kMostRequests; ++count) {
    crowd.push_back(std::make_unique<TestDisplay>(fixture.endpoint()));
    crowd.back()->send(fluid_at(1, 7, count));
    wait_until_taken(*crowd.back());
  }
  display.send(fluid_at(1, 7, 9));
  EXPECT_NE(
      display.next(Body::kFluidReply).fluid_reply().refused().message().find("measurements of fluid wait"),
      std::string::npos);
  // One that waits goes, and makes room.
  crowd.erase(crowd.begin() + 1);
  while (fixture.counters().sessions_closed.value() == 0) wait_until_taken(display);
  display.send(fluid_at(1, 7, 10));
  wait_until_taken(display);
  for (std::size_t count = 0; count < FluidDesk::kMostRequests; ++count) fixture.answer_fluid(7);
  EXPECT_TRUE(crowd.back()->next(Body::kFluidReply).fluid_reply().has_found());
}

}  // namespace fanlight::test
