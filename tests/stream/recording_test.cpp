// SPDX-License-Identifier: Apache-2.0
// The recorder as displays and scripts see it. The test takes the place of the recorder.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "server/state/recording_proxy.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;
using nlohmann::json;
using RecorderState = RecordingStatus::State;
using OrderWish = RecordingOrder::Wish;

class RecordingProxyTest : public testing::Test {
 protected:
  RecordingProxy make(double last_s, bool at_start = false, double most_s = 0) {
    return {{.folder = folder_.path(), .most_s = most_s, .last_s = last_s, .at_start = at_start},
            RecordingLink{orders_, bell_, status_, pictures_},
            [this] { return utc_s_; }};
  }
  RecordingOrder order() {
    auto order = orders_.take();
    if (!order) {
      ADD_FAILURE() << "there is no order";
      return {};
    }
    return *std::move(order);
  }
  void tell(RecorderState state, std::uint64_t order_done) {
    status_.draft() = {.state = state, .order_done = order_done};
    status_.publish();
  }

  TemporaryFolder folder_;
  Doorbell bell_;
  RecordingOrders orders_;
  Mailbox<RecordingStatus> status_{bell_};
  LineQueue pictures_;
  std::int64_t utc_s_ = 1'795'368'300;  // 2026-11-22 17:25:00
};

TEST_F(RecordingProxyTest, StartsAndStops) {
  RecordingProxy proxy = make(0, false, 90);
  EXPECT_FALSE(orders_.take());
  const auto started = proxy.request(RecordingWish::kStart);
  ASSERT_TRUE(started);
  EXPECT_EQ(*started, "fanlight-2026-11-22T172500Z.igs.mha");
  const RecordingOrder first = order();
  EXPECT_EQ(first.wish, OrderWish::kRecord);
  EXPECT_EQ(first.path, folder_ / *started);
  EXPECT_EQ(first.most_s, 90);
  EXPECT_EQ(proxy.request(RecordingWish::kStart).error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(proxy.request(RecordingWish::kStop).value(), *started);
  EXPECT_EQ(order().wish, OrderWish::kEnd);
  EXPECT_FALSE(proxy.request(RecordingWish::kStop));
  EXPECT_FALSE(proxy.request(RecordingWish::kKeep));
  EXPECT_EQ(proxy.request(RecordingWish::kStart).value(), "fanlight-2026-11-22T172500Z_2.igs.mha");
}

TEST_F(RecordingProxyTest, TakesNoNameThatAFileHas) {
  std::ofstream(folder_ / "fanlight-2026-11-22T172500Z.igs.mha") << "x";
  EXPECT_EQ(make(0).request(RecordingWish::kStart).value(), "fanlight-2026-11-22T172500Z_2.igs.mha");
}

TEST_F(RecordingProxyTest, KeepsTheLastSeconds) {
  RecordingProxy proxy = make(120);
  const RecordingOrder ring = order();
  EXPECT_EQ(ring.ring_s, 120);
  const auto kept = proxy.request(RecordingWish::kKeep);
  ASSERT_TRUE(kept);
  const RecordingOrder next = order();
  EXPECT_EQ(next.end_path, folder_ / *kept);
  EXPECT_FALSE(next.drops);
  EXPECT_EQ(next.ring_s, 120);
  EXPECT_NE(next.path, ring.path);
  // A recording takes the place of the ring, and the ring that of the recording.
  ASSERT_TRUE(proxy.request(RecordingWish::kStart));
  const RecordingOrder recording = order();
  EXPECT_TRUE(recording.drops);
  EXPECT_EQ(recording.ring_s, 0);
  EXPECT_FALSE(proxy.request(RecordingWish::kKeep));
  ASSERT_TRUE(proxy.request(RecordingWish::kStop));
  const RecordingOrder again = order();
  EXPECT_EQ(again.wish, OrderWish::kRecord);
  EXPECT_FALSE(again.drops);
  EXPECT_EQ(again.ring_s, 120);
}

TEST_F(RecordingProxyTest, GoesBackToTheRingAfterALimit) {
  RecordingProxy proxy = make(120, true, 60);
  EXPECT_EQ(order().most_s, 60);  // begun at the start
  tell(RecorderState::kRecording, 1);
  EXPECT_TRUE(proxy.update().changed);
  EXPECT_FALSE(orders_.take());
  tell(RecorderState::kFinishing, 1);
  EXPECT_TRUE(proxy.update().changed);
  EXPECT_EQ(order().ring_s, 120);
  EXPECT_TRUE(proxy.request(RecordingWish::kStart));
}

TEST_F(RecordingProxyTest, RefusesWithoutAFolder) {
  RecordingProxy proxy({}, std::nullopt, [] { return 0; });
  EXPECT_NE(proxy.request(RecordingWish::kStart).error().message.find("--recordings"), std::string::npos);
  EXPECT_FALSE(proxy.message().available());
  EXPECT_FALSE(proxy.update().changed);
}

StreamServer::Config config_with(const std::filesystem::path& folder) {
  StreamServer::Config config;
  config.state.recording.folder = folder;
  return config;
}

TEST(RecordingOverTheNetwork, IsStartedAndToldToAllDisplays) {
  const TemporaryFolder folder;
  ServerFixture fixture(config_with(folder.path()));
  TestDisplay one(fixture.endpoint());
  TestDisplay other(fixture.endpoint());
  EXPECT_TRUE(one.next(Body::kRecording).recording().available());
  EXPECT_EQ(other.next(Body::kRecording).recording().state(), v1::RecordingStatus::IDLE);
  v1::ClientMessage wish;
  wish.mutable_recording()->set_request_id(5);
  wish.mutable_recording()->set_wish(v1::RecordingRequest::START);
  one.send(wish);
  const auto reply = one.next(Body::kRecordingReply).recording_reply();
  EXPECT_EQ(reply.request_id(), 5U);
  const RecordingOrder order = fixture.next_recording_order();
  EXPECT_EQ(order.path, folder / reply.file());
  fixture.report_recording(
      {.state = RecorderState::kRecording, .order_done = order.number, .file = order.path, .frames = 7});
  const auto told = other.next(Body::kRecording).recording();
  EXPECT_EQ(told.state(), v1::RecordingStatus::RECORDING);
  EXPECT_EQ(told.file(), reply.file());  // without the folder
  EXPECT_EQ(told.frames(), 7U);
  // A second start is refused, and said to the one that asked.
  one.send(wish);
  EXPECT_TRUE(one.next(Body::kRecordingReply).recording_reply().has_refused());
  EXPECT_EQ(fixture.counters().recording_refusals.value(), 1U);
  wish.mutable_recording()->set_wish(static_cast<v1::RecordingRequest::Wish>(17));
  one.send(wish);
  EXPECT_TRUE(one.next(Body::kRecordingReply).recording_reply().has_refused());
}

TEST(RecordingOverTheNetwork, IsRefusedToScriptsWhileADisplayIsInControl) {
  const TemporaryFolder folder;
  ServerFixture fixture(config_with(folder.path()));
  TestDisplay display(fixture.endpoint());
  v1::Scene scene;
  scene.mutable_light()->set_up_mm(3);
  ASSERT_TRUE(display.change(scene).has_in_force());
  EXPECT_EQ(talk(fixture, "POST", "/api/recording", R"({"wish": "start"})").status, 409);
}

TEST(RecordingOverTheNetwork, IsAnsweredToScripts) {
  const TemporaryFolder folder;
  ServerFixture fixture(config_with(folder.path()));
  EXPECT_EQ(json::parse(talk(fixture, "GET", "/api/recording").body)["state"], "idle");
  const Answer started = talk(fixture, "POST", "/api/recording", R"({"wish": "start"})");
  EXPECT_EQ(started.status, 200);
  const RecordingOrder order = fixture.next_recording_order();
  EXPECT_EQ(order.path, folder / json::parse(started.body)["file"].get<std::string>());
  for (const char* body : {"{", "[]", R"({"wish": 3})", R"({"wish": "pause"})", R"("start")"})
    EXPECT_EQ(talk(fixture, "POST", "/api/recording", body).status, 400) << body;
  EXPECT_EQ(talk(fixture, "POST", "/api/recording", R"({"wish": "start"})", "text/plain").status, 415);
  EXPECT_EQ(talk(fixture, "POST", "/api/recording", R"({"wish": "keep"})").status, 409);
  EXPECT_EQ(talk(fixture, "DELETE", "/api/recording").status, 405);
}

TEST(RecordingOverTheNetwork, IsNotOfferedWithoutAFolder) {
  ServerFixture fixture;
  EXPECT_EQ(json::parse(talk(fixture, "GET", "/api/recording").body), json({{"available", false}}));
  EXPECT_EQ(talk(fixture, "POST", "/api/recording", R"({"wish": "start"})").status, 409);
}

}  // namespace
}  // namespace fanlight::test
