// SPDX-License-Identifier: Apache-2.0
// The replay of a recording over the network: requests of displays and scripts, and the answers.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "server/state/replay_proxy.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;
using nlohmann::json;
using Player = ReplayStatus::State;

TEST(ReplayWishes, AreWrittenAsTheyAreRead) {
  for (const char* text : {"play", "pause", "step=1", "step=-3", "seek=2.5", "speed=0.25", "ending=once",
                           "ending=loop", "ending=to-and-fro", "frame=1234567"})
    EXPECT_EQ(replay_words(replay_request(text).value()), text);
  EXPECT_EQ(replay_words(replay_request("step").value()), "step=1");
  for (const char* text : {"", "stop", "play=1", "step=", "step=a", "seek", "seek=nan", "speed=1x", "ending",
                           "ending=later", "=", "step==2"}) {
    const auto request = replay_request(text);
    ASSERT_FALSE(request) << text;
    EXPECT_NE(request.error().message.find("expected play, pause"), std::string::npos);
  }
}

class ReplayProxyTest : public testing::Test {
 protected:
  void tell(const ReplayStatus& status) {
    link_.status.draft() = status;
    link_.status.publish();
    proxy_.update();
  }
  std::string refusal(const char* wish) {
    const auto done = proxy_.request(replay_request(wish).value());
    return done ? "" : done.error().message;
  }
  Doorbell server_bell_;
  ReplayLink link_{server_bell_};
  ReplayProxy proxy_{link_};
};

TEST_F(ReplayProxyTest, RefusesWhereNoRecordingIsPlayed) {
  EXPECT_NE(refusal("pause").find("no recording"), std::string::npos);
  EXPECT_EQ(proxy_.message().state(), v1::ReplayStatus::NO_RECORDING);
}

TEST_F(ReplayProxyTest, ChecksEachNumber) {
  tell({.state = Player::kPlaying});
  for (const char* wish : {"step=0", "step=0.5", "step=1e9", "seek=-1", "speed=0", "speed=1001", "speed=-1",
                           "frame=-1", "frame=0.5", "frame=1e17"})
    EXPECT_NE(refusal(wish).find("expected"), std::string::npos) << wish;
  EXPECT_FALSE(link_.orders.take());
  EXPECT_EQ(refusal("step=-2"), "");
  EXPECT_EQ(link_.orders.take()->sweeps, -2);
  EXPECT_EQ(refusal("frame=9007199254740992"), "");
  EXPECT_EQ(link_.orders.take()->number, 9'007'199'254'740'992U);
  v1::ReplayRequest unknown;
  unknown.set_wish(static_cast<v1::ReplayRequest::Wish>(9));
  EXPECT_FALSE(proxy_.request(unknown));
  unknown.set_wish(v1::ReplayRequest::ENDING);
  unknown.set_ending(static_cast<v1::ReplayStatus::Ending>(9));
  EXPECT_FALSE(proxy_.request(unknown));
  EXPECT_EQ(replay_words(unknown), "ending=unknown");
}

TEST_F(ReplayProxyTest, RefusesWhatWouldReadACompressedFileAgainForEachFrame) {
  tell({.state = Player::kPlaying, .can_play_backward = false});
  EXPECT_NE(refusal("ending=to-and-fro").find("--ending to-and-fro"), std::string::npos);
  EXPECT_EQ(refusal("ending=loop"), "");
}

TEST_F(ReplayProxyTest, SaysWhatBecameOfTheFile) {
  tell({.state = Player::kPlaying, .file = ReplayStatus::File::kRemoved});
  EXPECT_NE(proxy_.message().trouble().find("removed"), std::string::npos);
  tell({.state = Player::kFailed, .file = ReplayStatus::File::kChanged, .trouble = "it is cut off"});
  EXPECT_EQ(proxy_.message().trouble(), "it is cut off");
}

TEST_F(ReplayProxyTest, RefusesWhereTheQueueIsFull) {
  tell({.state = Player::kPlaying});
  int taken = 0;
  while (taken < 100 && refusal("step").empty()) ++taken;
  EXPECT_EQ(taken, 16);
}

TEST(ReplayOverTheNetwork, IsControlledByDisplaysAndToldToAll) {
  ServerFixture fixture;
  TestDisplay one(fixture.endpoint());
  TestDisplay other(fixture.endpoint());
  EXPECT_EQ(other.next(Body::kReplay).replay().state(), v1::ReplayStatus::NO_RECORDING);
  fixture.report_replay({.state = Player::kPlaying, .sweep = 2, .sweeps = 5, .time_s = 1.5, .duration_s = 4});
  const auto told = other.next(Body::kReplay).replay();
  EXPECT_EQ(told.state(), v1::ReplayStatus::PLAYING);
  EXPECT_EQ(told.sweeps(), 5U);
  EXPECT_EQ(told.time_s(), 1.5);

  v1::ClientMessage wish;
  wish.mutable_replay()->set_request_id(5);
  wish.mutable_replay()->set_wish(v1::ReplayRequest::SEEK);
  wish.mutable_replay()->set_value(3.5);
  one.send(wish);
  const auto reply = one.next(Body::kReplayReply).replay_reply();
  EXPECT_EQ(reply.request_id(), 5U);
  EXPECT_TRUE(reply.taken());
  EXPECT_EQ(fixture.next_replay_order().time_s, 3.5);
  wish.mutable_replay()->set_value(-3.5);
  one.send(wish);
  EXPECT_TRUE(one.next(Body::kReplayReply).replay_reply().has_refused());
  EXPECT_EQ(fixture.counters().replay_refusals.value(), 1U);
}

TEST(ReplayOverTheNetwork, IsAnsweredToScripts) {
  ServerFixture fixture;
  EXPECT_EQ(json::parse(talk(fixture, "GET", "/api/replay").body), json({{"state", "no_recording"}}));
  EXPECT_EQ(talk(fixture, "POST", "/api/replay", R"({"wish": "pause"})").status, 409);
  TestDisplay display(fixture.endpoint());
  display.next(Body::kReplay);
  fixture.report_replay({.state = Player::kPaused, .ending = ReplayEnding::kLoop, .sweeps = 5});
  while (display.next(Body::kReplay).replay().state() != v1::ReplayStatus::PAUSED) {
  }
  const json state = json::parse(talk(fixture, "GET", "/api/replay").body);
  EXPECT_EQ(state["state"], "paused");
  EXPECT_EQ(state["ending"], "loop");
  EXPECT_EQ(talk(fixture, "POST", "/api/replay", R"({"wish": "step=-2"})").status, 202);
  EXPECT_EQ(fixture.next_replay_order().sweeps, -2);
  for (const char* body : {"{", "[]", R"({"wish": 3})", R"({"wish": "back"})", R"({"wish": "speed=0"})"})
    EXPECT_EQ(talk(fixture, "POST", "/api/replay", body).status, 400) << body;
  EXPECT_EQ(talk(fixture, "POST", "/api/replay", R"({"wish": "play"})", "text/plain").status, 415);
  EXPECT_EQ(talk(fixture, "PUT", "/api/replay").status, 405);
  v1::Scene scene;
  scene.mutable_light()->set_up_mm(3);
  ASSERT_TRUE(display.change(scene).has_in_force());
  EXPECT_EQ(talk(fixture, "POST", "/api/replay", R"({"wish": "play"})").status, 409)
      << "a display is in control";
}

TEST(ReplayOverTheNetwork, IsNeverCalledLive) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  fixture.report_replay({.state = Player::kPlaying, .sweeps = 5});
  fixture.show(1, 90);
  v1::Liveness told;
  while (told.state() != v1::Liveness::REPLAY && told.state() != v1::Liveness::LIVE)
    told = display.next(Body::kLiveness).liveness();
  EXPECT_EQ(told.state(), v1::Liveness::REPLAY);
  EXPECT_NE(talk(fixture, "GET", "/healthz").body.find("picture replay"), std::string::npos);
  EXPECT_NE(talk(fixture, "GET", "/metrics").body.find("fanlight_picture_live 0"), std::string::npos);
  EXPECT_NE(talk(fixture, "GET", "/metrics").body.find("fanlight_replay 1"), std::string::npos);
}

}  // namespace
}  // namespace fanlight::test
