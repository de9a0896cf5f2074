// SPDX-License-Identifier: Apache-2.0
// The cine over the network: requests of displays and scripts, and the answers.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "server/state/cine_proxy.hpp"
#include "server/state/path_privacy.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;
using nlohmann::json;

TEST(CineWishes, AreWrittenAsTheyAreRead) {
  for (const char* text : {"freeze", "live", "play", "pause", "step=1", "step=-3", "seek=2", "speed=0.25"})
    EXPECT_EQ(cine_words(cine_request(text).value()), text);
  EXPECT_EQ(cine_words(cine_request("step").value()), "step=1");
  for (const char* text : {"", "stop", "freeze=1", "live=", "step=a", "seek", "seek=nan", "speed=1x"}) {
    const auto request = cine_request(text);
    ASSERT_FALSE(request) << text;
    EXPECT_NE(request.error().message.find("expected freeze, live"), std::string::npos);
  }
}

class CineProxyTest : public testing::Test {
 protected:
  std::string refusal(const char* wish) {
    const auto done = proxy_.request(cine_request(wish).value());
    return done ? "" : done.error().message;
  }
  Doorbell render_bell_;
  Doorbell server_bell_;
  /// The next order to the render thread.
  std::optional<CineOrder> order() {
    const auto order = link_.orders.take();
    return order ? std::optional(std::get<CineOrder>(*order)) : std::nullopt;
  }
  RenderLink link_{render_bell_, server_bell_};
  CineProxy proxy_{link_};
};

TEST_F(CineProxyTest, ChecksEachNumber) {
  for (const char* wish : {"step=0", "step=0.5", "step=1e9", "seek=-1", "seek=1.5", "speed=0", "speed=5"})
    EXPECT_NE(refusal(wish).find("expected"), std::string::npos) << wish;
  EXPECT_FALSE(order());
  EXPECT_EQ(refusal("seek=7"), "");
  EXPECT_EQ(order()->volume, 7U);
  v1::CineRequest unknown;
  unknown.set_wish(static_cast<v1::CineRequest::Wish>(9));
  EXPECT_FALSE(proxy_.request(unknown));
  EXPECT_EQ(cine_words(unknown), "unknown");
}

TEST_F(CineProxyTest, RefusesWhereTheQueueIsFull) {
  int taken = 0;
  while (taken < 100 && refusal("step").empty()) ++taken;
  EXPECT_EQ(taken, 32);
}

TEST(CineOverTheNetwork, IsControlledByDisplaysAndToldToAll) {
  ServerFixture fixture;
  TestDisplay one(fixture.endpoint());
  TestDisplay other(fixture.endpoint());
  EXPECT_EQ(other.next(Body::kCine).cine().state(), v1::CineStatus::LIVE);
  fixture.show(1, 90);
  fixture.report_cine({.state = CineStatus::State::kFrozen, .volumes = 5, .volume = 2, .time_s = 1.5});
  const auto told = other.next(Body::kCine).cine();
  EXPECT_EQ(told.state(), v1::CineStatus::FROZEN);
  EXPECT_EQ(told.volume(), 2U);
  v1::Liveness liveness;
  while (liveness.state() != v1::Liveness::FROZEN) liveness = other.next(Body::kLiveness).liveness();
  EXPECT_EQ(liveness.sentence(), "The picture is frozen.");
  EXPECT_NE(talk(fixture, "GET", "/healthz").body.find("ok; source running; picture frozen"),
            std::string::npos);
  EXPECT_NE(talk(fixture, "GET", "/metrics").body.find("fanlight_picture_live 0"), std::string::npos);

  v1::ClientMessage wish;
  wish.mutable_cine()->set_request_id(5);
  wish.mutable_cine()->set_wish(v1::CineRequest::STEP);
  wish.mutable_cine()->set_value(-2);
  one.send(wish);
  const auto reply = one.next(Body::kCineReply).cine_reply();
  EXPECT_EQ(reply.request_id(), 5U);
  EXPECT_TRUE(reply.taken());
  EXPECT_EQ(fixture.next_cine_order().volumes, -2);
  wish.mutable_cine()->set_wish(v1::CineRequest::FREEZE);
  wish.mutable_cine()->set_volume_id(17);
  one.send(wish);
  EXPECT_TRUE(one.next(Body::kCineReply).cine_reply().taken());
  EXPECT_EQ(fixture.next_cine_order().volume_id, 17U);
  wish.mutable_cine()->set_wish(v1::CineRequest::STEP);
  wish.mutable_cine()->set_value(0);
  one.send(wish);
  EXPECT_TRUE(one.next(Body::kCineReply).cine_reply().has_refused());
  EXPECT_EQ(fixture.counters().cine_refusals.value(), 1U);
}

TEST(PathPrivacy, PutsANameInPlaceOfEachMention) {
  EXPECT_EQ(without_path("/data/DOE.mha: damaged (/data/DOE.mha, frame 3)", "/data/DOE.mha", "the recording"),
            "the recording: damaged (the recording, frame 3)");
  EXPECT_EQ(without_path("running", "", "the recording"), "running");
  EXPECT_EQ(without_path("a a", "a", "aa"), "aa aa");
}

TEST(CineOverTheNetwork, IsAnsweredToScripts) {
  ServerFixture fixture;
  EXPECT_EQ(json::parse(talk(fixture, "GET", "/api/cine").body)["state"], "live");
  EXPECT_EQ(talk(fixture, "POST", "/api/cine", R"({"wish": "freeze"})").status, 202);
  EXPECT_EQ(fixture.next_cine_order().wish, CineOrder::Wish::kFreeze);
  for (const char* body : {"{", "[]", R"({"wish": 3})", R"({"wish": "back"})", R"({"wish": "speed=0"})"})
    EXPECT_EQ(talk(fixture, "POST", "/api/cine", body).status, 400) << body;
  EXPECT_EQ(talk(fixture, "POST", "/api/cine", R"({"wish": "live"})", "text/plain").status, 415);
  EXPECT_EQ(talk(fixture, "PUT", "/api/cine").status, 405);
}

}  // namespace
}  // namespace fanlight::test
