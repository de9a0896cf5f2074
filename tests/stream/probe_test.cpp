// SPDX-License-Identifier: Apache-2.0
// The probe over real sockets: its state and its settings. The test takes the place of the acquisition
// thread.
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

ProbeStatus status_with(ProbeStatus::State state) {
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

/// A server, and the acquisition thread's end of its probe.
struct ProbeFixture {
  explicit ProbeFixture(ProbeControl control = ProbeControl::kEveryone) : fixture(64, "running", control) {}

  void publish(const ProbeStatus& status) {
    fixture.probe().status.draft() = status;
    fixture.probe().status.publish();
  }
  ProbeOrder next_order() {
    for (;;) {
      if (const ProbeOrder* order = fixture.probe().orders.newest()) return *order;
      std::this_thread::yield();
    }
  }

  ServerFixture fixture;
};

v1::ClientMessage change(std::uint64_t request_id, double sweep_deg) {
  v1::ClientMessage message;
  message.mutable_probe_change()->set_request_id(request_id);
  message.mutable_probe_change()->mutable_settings()->set_sweep_deg(sweep_deg);
  return message;
}

TEST(ProbeStream, ReportsTheProbeItsLossAndItsReturn) {
  ProbeFixture probe_fixture;
  TestDisplay client(probe_fixture.fixture.endpoint());
  client.next(Body::kHello);
  probe_fixture.publish(status_with(ProbeStatus::State::kStreaming));
  auto status = client.next(Body::kProbeStatus).probe_status();
  EXPECT_EQ(status.state(), v1::ProbeStatus::STREAMING);
  EXPECT_EQ(status.model(), "FL-1");
  EXPECT_EQ(status.settings().frames_a_volume(), 35U);
  EXPECT_EQ(status.sweep_deg().maximum(), 85);
  EXPECT_TRUE(status.may_be_set());

  auto lost = status_with(ProbeStatus::State::kLost);
  lost.times_lost = 1;
  probe_fixture.publish(lost);
  status = client.next(Body::kProbeStatus).probe_status();
  EXPECT_EQ(status.state(), v1::ProbeStatus::LOST);
  EXPECT_EQ(status.times_lost(), 1U);
  EXPECT_EQ(client.next(Body::kStatistics).statistics().source_state(), "probe lost");

  TestDisplay late(probe_fixture.fixture.endpoint());
  EXPECT_EQ(late.next(Body::kProbeStatus).probe_status().state(), v1::ProbeStatus::LOST);

  probe_fixture.publish(status_with(ProbeStatus::State::kStreaming));
  EXPECT_EQ(client.next(Body::kProbeStatus).probe_status().state(), v1::ProbeStatus::STREAMING);
  EXPECT_EQ(client.next(Body::kStatistics).statistics().source_state(), "running");
}

// When a probe looks deeper than before, scene fields that no one has chosen must follow; otherwise the
// picture would end at the old depth.
TEST(ProbeStream, FieldsThatNobodyHasChosenFollowTheDepthOfTheProbe) {
  ProbeFixture probe_fixture;
  TestDisplay client(probe_fixture.fixture.endpoint());
  client.next(Body::kHello);
  v1::Scene chosen;
  chosen.mutable_camera()->set_target_y_mm(33);
  client.change(chosen);
  auto status = status_with(ProbeStatus::State::kStreaming);
  status.geometry = {.columns = 64,
                     .rows = 64,
                     .pixel_width_mm = 2,
                     .pixel_height_mm = 3,
                     .face_column = 31.5,
                     .motor_radius_mm = 30};
  probe_fixture.publish(status);
  const auto update = client.next(Body::kScene).scene();
  const Scene expected = scene_for(status.geometry, radians(-35), radians(35));
  EXPECT_EQ(update.scene().rays().end_mm(), expected.rays.end_mm);
  EXPECT_EQ(update.default_scene().rays().end_mm(), expected.rays.end_mm);
  EXPECT_EQ(update.scene().camera().target_y_mm(), 33);
  EXPECT_EQ(update.default_scene().camera().target_y_mm(), expected.camera.target.y_mm);
  EXPECT_EQ(update.revision(), 3U);
}

TEST(ProbeStream, AChangeIsAnsweredWhenTheProbeHasAnswered) {
  ProbeFixture probe_fixture;
  TestDisplay client(probe_fixture.fixture.endpoint());
  probe_fixture.publish(status_with(ProbeStatus::State::kStreaming));
  client.next(Body::kProbeStatus);
  client.send(change(41, 50.1));
  const ProbeOrder order = probe_fixture.next_order();
  EXPECT_EQ(order.settings, (probe::Settings{.sweep_deg = 50.1, .frames_a_volume = 35, .depth_mm = 160}));

  auto answered = status_with(ProbeStatus::State::kStreaming);
  answered.settings.sweep_deg = 50;  // the probe rounds
  answered.order_answered = order.number;
  probe_fixture.publish(answered);
  const auto reply = client.next(Body::kProbeReply).probe_reply();
  EXPECT_EQ(reply.request_id(), 41U);
  EXPECT_EQ(reply.in_force().sweep_deg(), 50);
  EXPECT_EQ(probe_fixture.fixture.counters().probe_changes.value(), 1U);

  client.send(change(42, 500));
  answered.order_answered = probe_fixture.next_order().number;
  answered.refusal = "the probe's sweep was to be 500 deg, expected 10 to 85 deg";
  probe_fixture.publish(answered);
  const auto refused = client.next(Body::kProbeReply).probe_reply();
  EXPECT_EQ(refused.request_id(), 42U);
  EXPECT_EQ(refused.refused().message(), answered.refusal);
  EXPECT_EQ(probe_fixture.fixture.counters().probe_refusals.value(), 1U);
}

TEST(ProbeStream, ARefusedChangeTakesNoControl) {
  ProbeFixture probe_fixture;
  TestDisplay client(probe_fixture.fixture.endpoint());
  client.send(change(40, 50));  // there is no probe
  EXPECT_TRUE(client.next(Body::kProbeReply).probe_reply().has_refused());
  const auto holder = [&client] {
    v1::ClientMessage keep;
    keep.mutable_control()->set_wish(v1::ControlRequest::RELEASE);
    client.send(keep);
    return client.next(Body::kControlReply).control_reply().state().holder_session();
  };
  EXPECT_EQ(holder(), 0U);

  auto answered = status_with(ProbeStatus::State::kStreaming);
  probe_fixture.publish(answered);
  client.next(Body::kProbeStatus);
  client.send(change(41, 500));
  answered.order_answered = probe_fixture.next_order().number;
  EXPECT_TRUE(client.next(Body::kControl).control().mine()) << "while the probe considers it";
  answered.refusal = "the probe's sweep was to be 500 deg, expected 10 to 85 deg";
  probe_fixture.publish(answered);
  EXPECT_EQ(client.next(Body::kControl).control().holder_session(), 0U);
}

TEST(ProbeStream, AChangeIsRelativeToTheUnansweredOnes) {
  ProbeFixture probe_fixture;
  TestDisplay client(probe_fixture.fixture.endpoint());
  probe_fixture.publish(status_with(ProbeStatus::State::kStreaming));
  client.next(Body::kProbeStatus);
  client.send(change(1, 50));
  probe_fixture.next_order();
  auto second = change(2, 0);
  second.mutable_probe_change()->mutable_settings()->clear_sweep_deg();
  second.mutable_probe_change()->mutable_settings()->set_depth_mm(120);
  client.send(second);
  const ProbeOrder order = probe_fixture.next_order();
  EXPECT_EQ(order.settings, (probe::Settings{.sweep_deg = 50, .frames_a_volume = 35, .depth_mm = 120}));
  auto answered = status_with(ProbeStatus::State::kStreaming);
  answered.order_answered = order.number;
  probe_fixture.publish(answered);
  EXPECT_EQ(client.next(Body::kProbeReply).probe_reply().request_id(), 1U);
  EXPECT_EQ(client.next(Body::kProbeReply).probe_reply().request_id(), 2U);
}

std::string refusal_of(ServerFixture& fixture, const v1::ClientMessage& message) {
  TestDisplay client(fixture.endpoint());
  client.send(message);
  return client.next(Body::kProbeReply).probe_reply().refused().message();
}

TEST(ProbeStream, RefusesImpossibleChanges) {
  ProbeFixture probe_fixture;
  EXPECT_EQ(refusal_of(probe_fixture.fixture, change(1, 50)),
            "there is no probe to set, expected a source such as usb:1209:0001");
  TestDisplay client(probe_fixture.fixture.endpoint());
  probe_fixture.publish(status_with(ProbeStatus::State::kStreaming));
  client.next(Body::kProbeStatus);
  EXPECT_EQ(refusal_of(probe_fixture.fixture, change(1, std::numeric_limits<double>::infinity())),
            "a setting of the probe is no finite number, expected one");
  EXPECT_EQ(probe_fixture.fixture.counters().probe_refusals.value(), 2U);
  EXPECT_EQ(probe_fixture.fixture.probe().orders.newest(), nullptr);
}

TEST(ProbeStream, RefusesChangesThatTheServerDoesNotAllow) {
  ProbeFixture probe_fixture(ProbeControl::kNobody);
  TestDisplay client(probe_fixture.fixture.endpoint());
  probe_fixture.publish(status_with(ProbeStatus::State::kStreaming));
  EXPECT_FALSE(client.next(Body::kProbeStatus).probe_status().may_be_set());
  EXPECT_EQ(refusal_of(probe_fixture.fixture, change(1, 50)),
            "the probe may not be set over the network, expected a server with --probe-control everyone");
  EXPECT_EQ(probe_fixture.fixture.probe().orders.newest(), nullptr);
}

TEST(ProbeStream, LimitsTheUnansweredChanges) {
  ProbeFixture probe_fixture;
  TestDisplay client(probe_fixture.fixture.endpoint());
  probe_fixture.publish(status_with(ProbeStatus::State::kStreaming));
  client.next(Body::kProbeStatus);
  for (std::uint64_t request = 1; request <= 17; ++request) client.send(change(request, 50));
  const auto refused = client.next(Body::kProbeReply).probe_reply();
  EXPECT_EQ(refused.request_id(), 17U);
  EXPECT_EQ(refused.refused().message(), "16 changes of the probe are unanswered, expected a later request");
  auto answered = status_with(ProbeStatus::State::kStreaming);
  answered.order_answered = probe_fixture.next_order().number;
  EXPECT_EQ(answered.order_answered, 16U);
  probe_fixture.publish(answered);
  for (std::uint64_t request = 1; request <= 16; ++request) {
    EXPECT_EQ(client.next(Body::kProbeReply).probe_reply().request_id(), request);
  }
}

}  // namespace
}  // namespace fanlight::test
