// SPDX-License-Identifier: Apache-2.0
#include "server/client/display_state.hpp"

#include <gtest/gtest.h>

#include <string>

namespace fanlight::test {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

class DisplayStateTest : public testing::Test {
 protected:
  static v1::Hello hello() {
    v1::Hello hello;
    hello.set_picture_width(400);
    hello.set_picture_height(200);
    const auto add_field = [&](const char* name, double minimum, double maximum,
                               std::vector<const char*> choices) {
      v1::SceneField& field = *hello.add_fields();
      field.set_name(name);
      field.set_minimum(minimum);
      field.set_maximum(maximum);
      for (const char* const choice : choices) field.add_choices(choice);
    };
    add_field("mode", 0, 2, {"surface", "surface-and-volume", "slices"});
    add_field("camera.projection", 0, 1, {"parallel", "perspective"});
    add_field("camera.field_mm", 1, 500, {});
    add_field("detector.threshold", 0, 255, {});
    v1::Scene& scene = *hello.mutable_scene()->mutable_scene();
    scene.mutable_camera()->set_field_mm(100);
    scene.mutable_camera()->set_opening_deg(90);
    v1::Look& bone = *hello.add_presets();
    bone.set_name("bone");
    bone.mutable_scene()->mutable_detector()->set_threshold(120);
    return hello;
  }
  void tell(v1::Liveness::State state, const char* sentence = "") {
    v1::ServerMessage message;
    message.mutable_liveness()->set_state(state);
    message.mutable_liveness()->set_sentence(sentence);
    message.mutable_liveness()->set_limit_s(2);
    state_.take(message, now_ns_);
  }
  /// A picture that was captured `age_s` ago by the server's clock, which is 100 s ahead.
  void show(double age_s) {
    v1::ServerMessage clock;
    clock.mutable_statistics()->set_server_time_ns(now_ns_ + 100 * kSecond);
    state_.take(clock, now_ns_);
    v1::ServerMessage message;
    message.mutable_picture()->set_capture_time_ns(now_ns_ + 100 * kSecond -
                                                   static_cast<std::int64_t>(age_s * 1e9));
    message.mutable_picture()->mutable_levels()->set_threshold(60);
    state_.shown(message.picture());
  }
  std::string text() const { return state_.condition(now_ns_).text; }

  std::int64_t now_ns_ = 1000 * kSecond;
  DisplayState state_{hello()};
};

TEST_F(DisplayStateTest, SaysTheStateAndTheAgeOfThePicture) {
  EXPECT_EQ(text(), "WAITING");
  tell(v1::Liveness::LIVE);
  show(0.4);
  EXPECT_EQ(text(), "LIVE 0.4 s");
  now_ns_ += kSecond + kSecond / 2;
  EXPECT_EQ(text(), "LIVE 1.9 s");
  now_ns_ += kSecond / 5;
  EXPECT_EQ(text(), "DELAYED 2.1 s") << "whatever the server says of its own newest picture";
  tell(v1::Liveness::FROZEN);
  EXPECT_EQ(text(), "FROZEN 2.1 s");
  tell(v1::Liveness::REPLAY);
  EXPECT_EQ(text(), "REPLAY");
  tell(v1::Liveness::NOT_LIVE, "The probe is lost.");
  EXPECT_EQ(text(), "LOST, 2.1 s old");
  EXPECT_EQ(state_.condition(now_ns_).reason, "The probe is lost.");
  tell(v1::Liveness::LIVE);
  now_ns_ += 3 * kSecond;
  EXPECT_EQ(text(), "LOST, 5.1 s old");
  EXPECT_EQ(state_.condition(now_ns_).reason, "The server has not answered for 3 s.");
}

TEST_F(DisplayStateTest, TurnsAsThePageDoes) {
  const v1::Scene first = state_.turn(50, -20).scene_change().scene();
  EXPECT_DOUBLE_EQ(first.camera().yaw_deg(), -45) << "180 degrees for the height of the picture";
  EXPECT_DOUBLE_EQ(first.camera().pitch_deg(), -18);
  const v1::Scene second = state_.turn(200, -200).scene_change().scene();
  EXPECT_DOUBLE_EQ(second.camera().yaw_deg(), 135) << "from where the last turn ended, and around";
  EXPECT_DOUBLE_EQ(second.camera().pitch_deg(), -90);
}

TEST_F(DisplayStateTest, MovesTheLightToAPixel) {
  const v1::Scene moved = state_.light_to(300, 50).scene_change().scene();
  EXPECT_DOUBLE_EQ(moved.light().right_mm(), 50);
  EXPECT_DOUBLE_EQ(moved.light().up_mm(), 25);
  ASSERT_TRUE(state_.mode("slices"));
  const v1::Scene beside = state_.light_to(300, 150).scene_change().scene();
  EXPECT_DOUBLE_EQ(beside.light().right_mm(), 0) << "the surface is in the lower right quarter";
  EXPECT_DOUBLE_EQ(beside.light().up_mm(), 0);
}

TEST_F(DisplayStateTest, FollowsThePerspectiveOfTheLightsDepth) {
  v1::ServerMessage message;
  v1::Scene& scene = *message.mutable_scene()->mutable_scene();
  scene = hello().scene().scene();
  scene.mutable_camera()->set_projection(1);
  scene.mutable_camera()->set_distance_mm(50);  // the eye is 50 mm in front of the target at 90 degrees
  scene.mutable_light()->set_depth_mm(100);
  state_.take(message, now_ns_);
  EXPECT_NEAR(state_.light_to(300, 100).scene_change().scene().light().right_mm(), 100, 1e-9)
      << "100 mm from the eye a pixel covers twice as much";
}

TEST_F(DisplayStateTest, BeginsAThresholdWhereTheMeasuredOneIs) {
  show(0);
  EXPECT_DOUBLE_EQ(state_.threshold_by(2).scene_change().scene().detector().threshold(), 62);
  EXPECT_DOUBLE_EQ(state_.threshold_by(-500).scene_change().scene().detector().threshold(), 1);
  EXPECT_DOUBLE_EQ(state_.threshold_by(500).scene_change().scene().detector().threshold(), 255);
  EXPECT_DOUBLE_EQ(state_.zoom(100).scene_change().scene().camera().field_mm(), 500);
}

TEST_F(DisplayStateTest, KnowsItsPresetsAndModesOnly) {
  EXPECT_EQ(state_.preset(0)->scene_change().scene().detector().threshold(), 120);
  EXPECT_FALSE(state_.preset(1));
  EXPECT_FALSE(state_.preset(-1));
  EXPECT_FALSE(state_.mode("hologram"));
}

TEST_F(DisplayStateTest, FreezesAndGoesLiveAgain) {
  EXPECT_EQ(state_.freeze_or_live().cine().wish(), v1::CineRequest::FREEZE);
  v1::ServerMessage message;
  message.mutable_cine()->set_state(v1::CineStatus::FROZEN);
  state_.take(message, now_ns_);
  EXPECT_EQ(state_.freeze_or_live().cine().wish(), v1::CineRequest::LIVE);
  EXPECT_EQ(state_.step(-1).cine().value(), -1);
}

TEST_F(DisplayStateTest, ShowsARefusalForFourSeconds) {
  v1::ServerMessage message;
  message.mutable_scene_reply()->mutable_refused()->set_message("display 3 is in control");
  state_.take(message, now_ns_);
  EXPECT_EQ(state_.refusal(now_ns_ + 3 * kSecond), "display 3 is in control");
  EXPECT_EQ(state_.refusal(now_ns_ + 4 * kSecond), "");
}

TEST_F(DisplayStateTest, KnowsWhetherItsPicturesAreSentBeyondTheRoom) {
  EXPECT_FALSE(state_.is_relayed());
  for (const bool sending : {true, false}) {
    v1::ServerMessage message;
    message.mutable_relay()->set_sending(sending);
    state_.take(message, now_ns_);
    EXPECT_EQ(state_.is_relayed(), sending);
  }
}

TEST_F(DisplayStateTest, ForgetsARefusedChange) {
  state_.turn(50, 0);
  v1::ServerMessage refused;
  refused.mutable_scene_reply()->set_request_id(1);
  refused.mutable_scene_reply()->mutable_refused()->set_message("display 3 is in control");
  state_.take(refused, now_ns_);
  EXPECT_DOUBLE_EQ(state_.turn(50, 0).scene_change().scene().camera().yaw_deg(), -45);
}

TEST_F(DisplayStateTest, FollowsAServersClockThatIsSlower) {
  show(0.4);
  tell(v1::Liveness::LIVE);
  std::int64_t server_ns = now_ns_ + 100 * kSecond;
  for (int second = 0; second < 100'000; ++second) {  // 20 ppm: two seconds in that time
    now_ns_ += kSecond;
    server_ns += kSecond - 20'000;
    v1::ServerMessage clock;
    clock.mutable_statistics()->set_server_time_ns(server_ns);
    state_.take(clock, now_ns_);
  }
  v1::Picture picture;
  picture.set_capture_time_ns(server_ns - kSecond / 2);
  state_.shown(picture);
  EXPECT_EQ(text(), "LIVE 0.5 s");
}

TEST_F(DisplayStateTest, TakesTheSceneOfOthersButNotAnAnswerToAnEarlierChange) {
  state_.turn(50, 0);
  state_.turn(50, 0);
  v1::ServerMessage reply;
  reply.mutable_scene_reply()->set_request_id(1);
  reply.mutable_scene_reply()->mutable_in_force()->mutable_scene()->mutable_camera()->set_yaw_deg(-45);
  state_.take(reply, now_ns_);
  EXPECT_DOUBLE_EQ(state_.turn(0, 0).scene_change().scene().camera().yaw_deg(), -90);
}

}  // namespace
}  // namespace fanlight::test
