// Private views as displays have them: what is their own, who pays, and when they end.
#include <gtest/gtest.h>

#include "tests/support/fake_house.hpp"
#include "tests/support/stream_client.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

class PrivateViewStream : public testing::Test {
 protected:
  static v1::ViewReply change(StreamClient& client, const v1::Scene& scene, std::uint64_t request_id = 1) {
    v1::ClientMessage message;
    message.mutable_view()->set_request_id(request_id);
    *message.mutable_view()->mutable_scene() = scene;
    client.send(message);
    return client.next(Body::kViewReply).view_reply();
  }
  static v1::ViewReply leave(StreamClient& client) {
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
  /// A picture of the main view with what its passes took.
  void show_main(std::uint64_t volume_id, double cast_ms = 80, double light_ms = 10) {
    PictureStamp stamp{.picture_id = volume_id};
    stamp.volume.volume_id = volume_id;
    stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)] = cast_ms;
    stamp.stage_ms[static_cast<std::size_t>(Stage::kLight)] = light_ms;
    house_.show(stamp, 40);
  }

  /// The main view is at work right now, which it is taken to be for some time after a picture.
  void show_main_at_work(double busy_share, double cast_ms, double light_ms) {
    house_.set_main_busy_share(busy_share);
    show_main(++volumes_, cast_ms, light_ms);
    while (watching_.next(Body::kPicture).picture().volume_id() != volumes_) {
    }
  }

  FakeHouse house_;
  StreamClient watching_{house_.endpoint()};
  std::uint64_t volumes_ = 0;
};

TEST_F(PrivateViewStream, ALightIsTheSessionsOwnAndTheRestFollowsTheMainView) {
  StreamClient own(house_.endpoint());
  StreamClient other(house_.endpoint());
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
  const PrivateView wanted = house_.next_private_views()[0];
  EXPECT_EQ(wanted.scene.scene.light.right_mm, 33);
  EXPECT_FALSE(wanted.own_camera);
  EXPECT_EQ(wanted.scene.revision, reply.in_force().revision());

  // The main view's pictures go on until there is one of its own.
  show_main(2);
  EXPECT_FALSE(own.next(Body::kPicture).picture().private_view());
  house_.show_in(wanted,
                 {.view_id = wanted.view_id, .picture_id = 1, .scene_revision = wanted.scene.revision}, 200);
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

  // Another's camera moves the view, another's light does not.
  EXPECT_TRUE(other.change(yaw(12)).has_in_force());
  const v1::ViewState moved = own.next(Body::kView).view();
  EXPECT_EQ(moved.scene().camera().yaw_deg(), 12);
  EXPECT_EQ(moved.scene().light().right_mm(), 33);
  EXPECT_GT(moved.revision(), reply.in_force().revision());
  EXPECT_TRUE(other.change(light(-5)).has_in_force());
  EXPECT_EQ(house_.next_private_views()[0].scene.scene.light.right_mm, 33);

  EXPECT_FALSE(leave(own).in_force().is_private());
  EXPECT_FALSE(own.next(Body::kPicture).picture().private_view()) << "the one on show, at once";
  EXPECT_EQ(house_.next_private_views()[0].view_id, 0U);
}

TEST_F(PrivateViewStream, RefusesWhatIsTheMainViewsAndWhatCannotBe) {
  StreamClient client(house_.endpoint());
  v1::Scene threshold;
  threshold.mutable_detector()->set_threshold(30);
  EXPECT_NE(change(client, threshold).refused().message().find("detector.threshold is the main view's"),
            std::string::npos);
  v1::Scene ambient;
  ambient.mutable_light()->set_ambient(7);
  const v1::Error refused = change(client, ambient).refused();
  EXPECT_EQ(refused.field(), "light.ambient");
  EXPECT_EQ(house_.counters().private_view_refusals.value(), 2U);
  EXPECT_EQ(house_.counters().private_views.value(), 0U);
  EXPECT_FALSE(leave(client).in_force().is_private()) << "none to leave is no fault";
}

TEST_F(PrivateViewStream, AreWithinABudgetThatTheMainViewLeaves) {
  StreamClient first(house_.endpoint());
  StreamClient second(house_.endpoint());
  show_main_at_work(0.5, 300, 20);
  EXPECT_EQ(change(first, yaw(5)).refused().message(),
            "a private camera would take 640 ms of each second; the main view leaves 500, of which other "
            "private views take 0, expected the main view's camera, or a main view that does less");
  EXPECT_TRUE(change(first, light(5)).has_in_force());
  show_main_at_work(0.93, 300, 20);
  EXPECT_NE(
      change(second, light(5)).refused().message().find("leaves 70, of which other private views take 40"),
      std::string::npos);
  EXPECT_TRUE(change(first, light(6)).has_in_force()) << "a view that there is may move its light";
  EXPECT_TRUE(change(first, yaw(5)).has_refused()) << "but not become a dearer one";
  first.vanish();
  for (int tries = 0; house_.counters().private_views.value() > 0 && tries < 1000; ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(house_.counters().private_views.value(), 0U) << "who goes leaves it to others";
  show_main_at_work(0.93, 300, 20);
  EXPECT_TRUE(change(second, light(5)).has_in_force());
}

TEST_F(PrivateViewStream, ACameraMustFitBetweenTwoVolumes) {
  StreamClient client(house_.endpoint());
  show_main_at_work(0.5, 230, 10);
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  show_main_at_work(0.5, 230, 10);
  // 480 ms of each second would do, but not 240 ms at once.
  const v1::ViewReply reply = change(client, yaw(5));
  ASSERT_TRUE(reply.has_refused());
  EXPECT_NE(reply.refused().message().find("between two volumes"), std::string::npos)
      << reply.refused().message();
  EXPECT_TRUE(change(client, light(5)).has_in_force());
}

TEST_F(PrivateViewStream, TakeAsLongAsTheirOwnPicturesTook) {
  StreamClient client(house_.endpoint());
  EXPECT_TRUE(change(client, light(5)).has_in_force());
  const PrivateView wanted = house_.next_private_views()[0];
  PictureStamp dear{.view_id = wanted.view_id, .picture_id = 1, .scene_revision = wanted.scene.revision};
  dear.stage_ms[static_cast<std::size_t>(Stage::kFinish)] = 400;
  house_.show_in(wanted, dear, 90);
  while (!client.next(Body::kPicture).picture().private_view()) {
  }
  show_main_at_work(0.5, 80, 10);
  EXPECT_NE(change(client, light(6)).refused().message().find("would take 820 ms"), std::string::npos);
}

TEST_F(PrivateViewStream, AreSoManyAndNoMore) {
  std::vector<std::unique_ptr<StreamClient>> clients;
  for (std::size_t view = 0; view < kMostPrivateViews; ++view) {
    clients.push_back(std::make_unique<StreamClient>(house_.endpoint()));
    EXPECT_TRUE(change(*clients.back(), light(5)).has_in_force());
  }
  StreamClient more(house_.endpoint());
  EXPECT_EQ(change(more, light(5)).refused().message(),
            "there are 4 private views already, expected some patience");
  leave(*clients.front());
  EXPECT_TRUE(change(more, light(5)).has_in_force());
}

TEST_F(PrivateViewStream, EndWhereTheMainViewLeavesThemNoTime) {
  StreamClient client(house_.endpoint());
  show_main(1);
  client.next(Body::kPicture);
  EXPECT_TRUE(change(client, light(5)).has_in_force());
  const v1::ViewState ended = client.next(Body::kView).view();
  EXPECT_FALSE(ended.is_private());
  EXPECT_EQ(ended.ended(), "the main view left it no time for 5 s");
  EXPECT_EQ(house_.counters().private_views_ended.value(), 1U);
}

TEST(PrivateViewsOfNone, AreRefused) {
  FakeHouse house(StreamServer::Config{.most_connections = 8, .most_private_views = 0});
  StreamClient client(house.endpoint());
  v1::ClientMessage message;
  message.mutable_view()->mutable_scene()->mutable_light()->set_right_mm(1);
  client.send(message);
  EXPECT_EQ(client.next(Body::kViewReply).view_reply().refused().message(),
            "there are no private views here, expected the main view");
}

}  // namespace
}  // namespace fanlight::test
