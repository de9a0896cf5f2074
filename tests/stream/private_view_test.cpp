// SPDX-License-Identifier: Apache-2.0
// Private views over real sockets: which pictures a display receives, the budget, and how a view ends. The
// unit tests of the budget are in view_admission_test.cpp.
#include <gtest/gtest.h>

#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

class PrivateViewStream : public testing::Test {
 protected:
  static v1::ViewReply change(TestDisplay& client, const v1::Scene& scene, std::uint64_t request_id = 1) {
    v1::ClientMessage message;
    message.mutable_view()->set_request_id(request_id);
    *message.mutable_view()->mutable_scene() = scene;
    client.send(message);
    return client.next(Body::kViewReply).view_reply();
  }
  static v1::ViewReply leave(TestDisplay& client) {
    v1::ClientMessage message;
    message.mutable_view()->set_leave(true);
    client.send(message);
    return client.next(Body::kViewReply).view_reply();
  }
  static v1::Scene light(double right_mm) {
    v1::Scene scene;
    scene.mutable_light()->set_right_mm(right_mm);
    return scene;
  }
  static v1::Scene yaw(double yaw_deg) {
    v1::Scene scene;
    scene.mutable_camera()->set_yaw_deg(yaw_deg);
    return scene;
  }
  /// Shows a picture of the main view with the times of its passes.
  void show_main(std::uint64_t volume_id, double cast_ms = 80, double light_ms = 10) {
    PictureStamp stamp{.picture_id = volume_id};
    stamp.volume.volume_id = volume_id;
    stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)] = cast_ms;
    stamp.stage_ms[static_cast<std::size_t>(Stage::kLight)] = light_ms;
    fixture_.show(stamp, 40);
  }

  /// Shows a picture of the main view with a busy share, and waits until the server has shown it.
  void show_main_at_work(double busy_share, double cast_ms, double light_ms) {
    fixture_.set_main_busy_share(busy_share);
    show_main(++volumes_, cast_ms, light_ms);
    while (watching_.next(Body::kPicture).picture().volume_id() != volumes_) {
    }
  }

  ServerFixture fixture_;
  TestDisplay watching_{fixture_.endpoint()};
  std::uint64_t volumes_ = 0;
};

TEST_F(PrivateViewStream, TheLightIsPrivateAndTheRestFollowsTheMainView) {
  TestDisplay own(fixture_.endpoint());
  TestDisplay other(fixture_.endpoint());
  own.next(Body::kHello);
  other.next(Body::kHello);
  show_main(1);
  EXPECT_FALSE(own.next(Body::kPicture).picture().private_view());

  const v1::ViewReply reply = change(own, light(33), 9);
  ASSERT_TRUE(reply.has_in_force()) << reply.refused().message();
  EXPECT_TRUE(reply.in_force().is_private());
  ASSERT_EQ(reply.in_force().own_size(), 1);
  EXPECT_EQ(reply.in_force().own(0), "light");
  EXPECT_EQ(reply.in_force().scene().light().right_mm(), 33);
  const PrivateView wanted = fixture_.next_private_views()[0];
  EXPECT_EQ(wanted.scene.scene.light.right_mm, 33);
  EXPECT_FALSE(wanted.own_camera);
  EXPECT_EQ(wanted.scene.revision, reply.in_force().revision());

  // The client receives the main view until the first picture of its private view.
  show_main(2);
  EXPECT_FALSE(own.next(Body::kPicture).picture().private_view());
  fixture_.show_in(
      wanted, {.view_id = wanted.view_id, .picture_id = 1, .scene_revision = wanted.scene.revision}, 200);
  const v1::SceneShown shown = own.next(Body::kSceneShown).scene_shown();
  EXPECT_EQ(shown.request_id(), 9U);
  EXPECT_TRUE(shown.private_view());
  EXPECT_TRUE(own.next(Body::kPicture).picture().private_view());
  show_main(3);
  for (std::uint64_t seen = 0; seen != 3;) {
    const v1::Picture picture = other.next(Body::kPicture).picture();
    EXPECT_FALSE(picture.private_view()) << "another session sees the main view";
    seen = picture.picture_id();
  }

  // The view follows the camera of the main view, but not its light.
  EXPECT_TRUE(other.change(yaw(12)).has_in_force());
  const v1::ViewState moved = own.next(Body::kView).view();
  EXPECT_EQ(moved.scene().camera().yaw_deg(), 12);
  EXPECT_EQ(moved.scene().light().right_mm(), 33);
  EXPECT_GT(moved.revision(), reply.in_force().revision());
  EXPECT_TRUE(other.change(light(-5)).has_in_force());
  EXPECT_EQ(fixture_.next_private_views()[0].scene.scene.light.right_mm, 33);

  EXPECT_FALSE(leave(own).in_force().is_private());
  EXPECT_FALSE(own.next(Body::kPicture).picture().private_view()) << "the newest one, at once";
  EXPECT_EQ(fixture_.next_private_views()[0].view_id, 0U);
}

TEST_F(PrivateViewStream, RefusesFieldsOfTheMainViewAndValuesOutOfRange) {
  TestDisplay client(fixture_.endpoint());
  v1::Scene threshold;
  threshold.mutable_detector()->set_threshold(30);
  EXPECT_NE(change(client, threshold).refused().message().find("detector.threshold is the main view's"),
            std::string::npos);
  v1::Scene ambient;
  ambient.mutable_light()->set_ambient(7);
  const v1::Error refused = change(client, ambient).refused();
  EXPECT_EQ(refused.field(), "light.ambient");
  EXPECT_EQ(fixture_.counters().private_view_refusals.value(), 2U);
  EXPECT_EQ(fixture_.counters().private_views.value(), 0U);
  EXPECT_FALSE(leave(client).in_force().is_private()) << "leaving without a view is no error";
}

TEST_F(PrivateViewStream, ASessionThatLeavesFreesItsShareOfTheBudget) {
  TestDisplay first(fixture_.endpoint());
  TestDisplay second(fixture_.endpoint());
  show_main_at_work(0.5, 300, 240);
  EXPECT_TRUE(change(first, light(5)).has_in_force());
  show_main_at_work(0.93, 300, 240);
  EXPECT_NE(change(second, light(5)).refused().message().find("other displays with views of their own"),
            std::string::npos);
  first.vanish();
  while (fixture_.counters().private_views.value() > 0) watching_.next(Body::kStatistics);
  show_main_at_work(0.93, 300, 240);
  EXPECT_TRUE(change(second, light(5)).has_in_force());
}

TEST_F(PrivateViewStream, PicturesOfAPrivateViewCountForItsCost) {
  TestDisplay client(fixture_.endpoint());
  EXPECT_TRUE(change(client, light(5)).has_in_force());
  const PrivateView wanted = fixture_.next_private_views()[0];
  PictureStamp expensive{.view_id = wanted.view_id, .picture_id = 1, .scene_revision = wanted.scene.revision};
  expensive.stage_ms[static_cast<std::size_t>(Stage::kFinish)] = 1200;
  for (int picture = 0; picture < 2; ++picture) {  // the first ones do not count
    expensive.picture_id += 1;
    fixture_.show_in(wanted, expensive, 90);
    while (!client.next(Body::kPicture).picture().private_view()) {
    }
    show_main_at_work(0.5, 80, 10);
  }
  EXPECT_NE(change(client, light(6)).refused().message().find("would take 60 %"), std::string::npos);
}

TEST_F(PrivateViewStream, EndsAViewThatTheMainViewLeavesNoTime) {
  TestDisplay client(fixture_.endpoint());
  show_main(1);
  client.next(Body::kPicture);
  EXPECT_TRUE(change(client, light(5)).has_in_force());
  const v1::ViewState ended = client.next(Body::kView).view();
  EXPECT_FALSE(ended.is_private());
  EXPECT_EQ(ended.ended(), "this machine had no time for it for 5 s");
  EXPECT_EQ(fixture_.counters().private_views_ended.value(), 1U);
}

TEST(PrivateViewStreamWithoutViews, RefusesThem) {
  ServerFixture fixture(StreamServer::Config{.state = {.most_private_views = 0}, .most_connections = 8});
  TestDisplay client(fixture.endpoint());
  v1::ClientMessage message;
  message.mutable_view()->mutable_scene()->mutable_light()->set_right_mm(1);
  client.send(message);
  EXPECT_EQ(client.next(Body::kViewReply).view_reply().refused().message(),
            "there are no private views here, expected the main view");
}

}  // namespace
}  // namespace fanlight::test
