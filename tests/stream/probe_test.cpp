// What displays hear of a probe and may ask of it, with the test in the acquisition thread's place.
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/fake_house.hpp"
#include "tests/support/stream_client.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

ProbeStatus a_status(ProbeStatus::State state) {
  ProbeStatus status;
  status.state = state;
  status.identity = {.model = "FL-1", .serial = "0007", .firmware = "1.0"};
  status.capabilities = {.least_sweep_deg = 10,
                         .most_sweep_deg = 85,
                         .least_frames = 8,
                         .most_frames = 140,
                         .least_depth_mm = 40,
                         .most_depth_mm = 240,
                         .most_columns = 512,
                         .most_rows = 512};
  status.settings = {.sweep_deg = 70, .frames_a_volume = 35, .depth_mm = 160};
  return status;
}

/// A house with a probe that the test plays.
struct ProbeHouse {
  explicit ProbeHouse(ProbeControl control = ProbeControl::kEveryone) : house(64, "running", control) {}

  void tell(const ProbeStatus& status) {
    house.probe().status.draft() = status;
    house.probe().status.publish();
  }
  ProbeOrder next_order() {
    for (;;) {
      if (const ProbeOrder* order = house.probe().orders.newest()) return *order;
      std::this_thread::yield();
    }
  }

  FakeHouse house;
};

v1::ClientMessage change(std::uint64_t request_id, double sweep_deg) {
  v1::ClientMessage message;
  message.mutable_probe_change()->set_request_id(request_id);
  message.mutable_probe_change()->mutable_settings()->set_sweep_deg(sweep_deg);
  return message;
}

TEST(ProbeStream, TellsOfTheProbeItsLossAndItsReturn) {
  ProbeHouse played;
  StreamClient client(played.house.endpoint());
  client.next(Body::kHello);
  played.tell(a_status(ProbeStatus::State::kStreaming));
  auto status = client.next(Body::kProbeStatus).probe_status();
  EXPECT_EQ(status.state(), v1::ProbeStatus::STREAMING);
  EXPECT_EQ(status.model(), "FL-1");
  EXPECT_EQ(status.settings().frames_a_volume(), 35U);
  EXPECT_EQ(status.sweep_deg().maximum(), 85);
  EXPECT_TRUE(status.may_be_set());

  auto lost = a_status(ProbeStatus::State::kLost);
  lost.times_lost = 1;
  played.tell(lost);
  status = client.next(Body::kProbeStatus).probe_status();
  EXPECT_EQ(status.state(), v1::ProbeStatus::LOST);
  EXPECT_EQ(status.times_lost(), 1U);
  EXPECT_EQ(client.next(Body::kStatistics).statistics().source_state(), "probe lost");

  StreamClient late(played.house.endpoint());
  EXPECT_EQ(late.next(Body::kProbeStatus).probe_status().state(), v1::ProbeStatus::LOST);

  played.tell(a_status(ProbeStatus::State::kStreaming));
  EXPECT_EQ(client.next(Body::kProbeStatus).probe_status().state(), v1::ProbeStatus::STREAMING);
  EXPECT_EQ(client.next(Body::kStatistics).statistics().source_state(), "running");
}

// A probe that looks deeper than before: whatever nobody chose follows, or the picture would end where it
// did.
TEST(ProbeStream, TheSceneFollowsTheProbesDepthWhereNobodyChoseOtherwise) {
  ProbeHouse played;
  StreamClient client(played.house.endpoint());
  client.next(Body::kHello);
  v1::Scene chosen;
  chosen.mutable_camera()->set_target_y_mm(33);
  client.change(chosen);
  auto status = a_status(ProbeStatus::State::kStreaming);
  status.geometry = {.columns = 64,
                     .rows = 64,
                     .pixel_width_mm = 2,
                     .pixel_height_mm = 3,
                     .face_column = 31.5,
                     .motor_radius_mm = 30};
  played.tell(status);
  const auto told = client.next(Body::kScene).scene();
  const Scene expected = scene_for(status.geometry, radians(-35), radians(35));
  EXPECT_EQ(told.scene().rays().end_mm(), expected.rays.end_mm);
  EXPECT_EQ(told.default_scene().rays().end_mm(), expected.rays.end_mm);
  EXPECT_EQ(told.scene().camera().target_y_mm(), 33);
  EXPECT_EQ(told.default_scene().camera().target_y_mm(), expected.camera.target.y_mm);
  EXPECT_EQ(told.revision(), 3U);
}

TEST(ProbeStream, AChangeIsAnsweredOnceTheProbeHasAnswered) {
  ProbeHouse played;
  StreamClient client(played.house.endpoint());
  played.tell(a_status(ProbeStatus::State::kStreaming));
  client.next(Body::kProbeStatus);
  client.send(change(41, 50.1));
  const ProbeOrder order = played.next_order();
  EXPECT_EQ(order.settings, (probe::Settings{.sweep_deg = 50.1, .frames_a_volume = 35, .depth_mm = 160}));

  auto answered = a_status(ProbeStatus::State::kStreaming);
  answered.settings.sweep_deg = 50;  // rounded
  answered.order_answered = order.number;
  played.tell(answered);
  const auto reply = client.next(Body::kProbeReply).probe_reply();
  EXPECT_EQ(reply.request_id(), 41U);
  EXPECT_EQ(reply.in_force().sweep_deg(), 50);
  EXPECT_EQ(played.house.counters().probe_changes.value(), 1U);

  client.send(change(42, 500));
  answered.order_answered = played.next_order().number;
  answered.refusal = "the probe's sweep was to be 500 deg, expected 10 to 85 deg";
  played.tell(answered);
  const auto refused = client.next(Body::kProbeReply).probe_reply();
  EXPECT_EQ(refused.request_id(), 42U);
  EXPECT_EQ(refused.refused().message(), answered.refusal);
  EXPECT_EQ(played.house.counters().probe_refusals.value(), 1U);
}

TEST(ProbeStream, AChangeOnTopOfOneThatIsNotAnsweredKeepsIt) {
  ProbeHouse played;
  StreamClient client(played.house.endpoint());
  played.tell(a_status(ProbeStatus::State::kStreaming));
  client.next(Body::kProbeStatus);
  client.send(change(1, 50));
  played.next_order();
  auto second = change(2, 0);
  second.mutable_probe_change()->mutable_settings()->clear_sweep_deg();
  second.mutable_probe_change()->mutable_settings()->set_depth_mm(120);
  client.send(second);
  const ProbeOrder order = played.next_order();
  EXPECT_EQ(order.settings, (probe::Settings{.sweep_deg = 50, .frames_a_volume = 35, .depth_mm = 120}));
  auto answered = a_status(ProbeStatus::State::kStreaming);
  answered.order_answered = order.number;
  played.tell(answered);
  EXPECT_EQ(client.next(Body::kProbeReply).probe_reply().request_id(), 1U);
  EXPECT_EQ(client.next(Body::kProbeReply).probe_reply().request_id(), 2U);
}

std::string refusal_of(FakeHouse& house, const v1::ClientMessage& message) {
  StreamClient client(house.endpoint());
  client.send(message);
  return client.next(Body::kProbeReply).probe_reply().refused().message();
}

TEST(ProbeStream, RefusesWhatCannotBe) {
  ProbeHouse played;
  EXPECT_EQ(refusal_of(played.house, change(1, 50)),
            "there is no probe to set, expected a source such as usb:1209:0001");
  StreamClient client(played.house.endpoint());
  played.tell(a_status(ProbeStatus::State::kStreaming));
  client.next(Body::kProbeStatus);
  EXPECT_EQ(refusal_of(played.house, change(1, std::numeric_limits<double>::infinity())),
            "a setting of the probe is no finite number, expected one");
  EXPECT_EQ(played.house.counters().probe_refusals.value(), 2U);
  EXPECT_EQ(played.house.probe().orders.newest(), nullptr);
}

TEST(ProbeStream, WhoMayNotSetTheProbeIsToldSo) {
  ProbeHouse played(ProbeControl::kNobody);
  StreamClient client(played.house.endpoint());
  played.tell(a_status(ProbeStatus::State::kStreaming));
  EXPECT_FALSE(client.next(Body::kProbeStatus).probe_status().may_be_set());
  EXPECT_EQ(refusal_of(played.house, change(1, 50)),
            "the probe may not be set over the network, expected a server with --probe-control everyone");
  EXPECT_EQ(played.house.probe().orders.newest(), nullptr);
}

TEST(ProbeStream, ADisplayThatAsksTooMuchOfAMuteProbeIsRefused) {
  ProbeHouse played;
  StreamClient client(played.house.endpoint());
  played.tell(a_status(ProbeStatus::State::kStreaming));
  client.next(Body::kProbeStatus);
  for (std::uint64_t request = 1; request <= 17; ++request) client.send(change(request, 50));
  const auto refused = client.next(Body::kProbeReply).probe_reply();
  EXPECT_EQ(refused.request_id(), 17U);
  EXPECT_EQ(refused.refused().message(), "16 changes of the probe are unanswered, expected some patience");
  auto answered = a_status(ProbeStatus::State::kStreaming);
  answered.order_answered = played.next_order().number;
  EXPECT_EQ(answered.order_answered, 16U);
  played.tell(answered);
  for (std::uint64_t request = 1; request <= 16; ++request) {
    EXPECT_EQ(client.next(Body::kProbeReply).probe_reply().request_id(), request);
  }
}

}  // namespace
}  // namespace fanlight::test
