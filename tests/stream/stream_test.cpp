// SPDX-License-Identifier: Apache-2.0
// The server and its sessions over real sockets on loopback. The test takes the place of the renderer.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "server/state/scene_message.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;
using boost::system::system_error;

v1::Scene threshold(double value) {
  v1::Scene scene;
  scene.mutable_detector()->set_threshold(value);
  return scene;
}

TEST(SceneMessage, RoundTripsEveryField) {
  Scene scene;
  for (const SceneField& field : scene_fields()) {
    if (!field.is_text()) field.set(scene, field.maximum);
  }
  scene.transfer = TransferFunction::parse("7 #102030 0.25").value();
  // Fields whose maxima contradict each other.
  scene.rays.start_mm = 1;
  scene.crop.left_mm = scene.crop.near_mm = scene.crop.below_mm = 1;
  const auto back = changed_scene(Scene{}, scene_message(scene));
  ASSERT_TRUE(back) << back.error().message;
  for (const SceneField& field : scene_fields()) EXPECT_TRUE(field.same(*back, scene)) << field.name;
}

TEST(SceneMessage, HasExactlyTheFieldsOfTheTable) {
  std::size_t values = 0;
  const auto* scene = v1::Scene::descriptor();
  for (int index = 0; index < scene->field_count(); ++index) {
    const auto* group = scene->field(index)->message_type();
    values += group == nullptr ? 1U : static_cast<std::size_t>(group->field_count());
  }
  EXPECT_EQ(values, scene_fields().size());
}

TEST(SceneMessage, KeepsAbsentFields) {
  Scene scene;
  scene.light.up_mm = 17;
  const auto changed = changed_scene(scene, threshold(99));
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->detector.threshold, 99);
  EXPECT_EQ(changed->light.up_mm, 17);
}

TEST(Stream, SendsAHelloWithTheSceneAndItsFields) {
  ServerFixture fixture;
  TestDisplay client(fixture.endpoint());
  const auto message = client.next();
  ASSERT_EQ(message.body_case(), Body::kHello);
  const v1::Hello& hello = message.hello();
  EXPECT_EQ(hello.protocol_version(), 2U);
  EXPECT_EQ(hello.source(), "fake:");
  EXPECT_EQ(hello.picture_width(), ServerFixture::kWidth);
  EXPECT_NE(hello.run_id(), 0U);
  ASSERT_EQ(static_cast<std::size_t>(hello.fields_size()), scene_fields().size());
  EXPECT_EQ(hello.scene().revision(), 1U);
  EXPECT_TRUE(changed_scene(Scene{}, hello.scene().scene()));
  EXPECT_TRUE(changed_scene(Scene{}, hello.default_scene()));
}

TEST(Stream, ALateDisplayReceivesTheNewestPicture) {
  ServerFixture fixture;
  TestDisplay first(fixture.endpoint());
  first.next(Body::kHello);
  fixture.show(5, 128);
  EXPECT_EQ(first.next(Body::kPicture).picture().picture_id(), 5U);
  TestDisplay second(fixture.endpoint());
  const auto picture = second.next(Body::kPicture).picture();
  EXPECT_EQ(picture.picture_id(), 5U);
  EXPECT_EQ(picture.width(), ServerFixture::kWidth);
  ASSERT_GT(picture.jpeg().size(), 4U);
  EXPECT_EQ(picture.jpeg().substr(0, 2), "\xFF\xD8");
}

TEST(Stream, ReportsTheMeasuresOfTheDeadlinePlan) {
  ServerFixture fixture;
  TestDisplay client(fixture.endpoint());
  fixture.show({.picture_id = 1}, 128);
  const auto full = client.next(Body::kPicture).picture();
  EXPECT_EQ(full.deadline_level(), 0U);
  EXPECT_EQ(full.measures_size(), 0);
  fixture.show({.picture_id = 2,
                .deadline_level = 4,
                .measures = {.coarse = true, .wide_step = true, .cheap_filters = true}},
               128);
  const auto coarse = client.next(Body::kPicture).picture();
  EXPECT_EQ(coarse.deadline_level(), 4U);
  EXPECT_EQ(std::vector<std::string>(coarse.measures().begin(), coarse.measures().end()),
            (std::vector<std::string>{"coarse picture", "wide step", "cheap filters"}));
}

TEST(Stream, EncodesOnceForManyDisplaysAndNeverWithoutOne) {
  ServerFixture fixture;
  fixture.show(1, 10);
  std::vector<std::unique_ptr<TestDisplay>> clients;
  for (int count = 0; count < 20; ++count) {
    clients.push_back(std::make_unique<TestDisplay>(fixture.endpoint()));
    clients.back()->next(Body::kPicture);
  }
  const auto before = fixture.counters().pictures_encoded.value();
  EXPECT_EQ(before, 1U);
  fixture.show(2, 20);
  for (const auto& client : clients) EXPECT_EQ(client->next(Body::kPicture).picture().picture_id(), 2U);
  EXPECT_EQ(fixture.counters().pictures_encoded.value(), before + 1);
}

TEST(Stream, AppliesAChangeAndNotifiesTheOthers) {
  ServerFixture fixture;
  TestDisplay changer(fixture.endpoint());
  TestDisplay watcher(fixture.endpoint());
  watcher.next(Body::kHello);
  const auto reply = changer.change(threshold(77), 42);
  EXPECT_EQ(reply.request_id(), 42U);
  ASSERT_TRUE(reply.has_in_force());
  EXPECT_EQ(reply.in_force().revision(), 2U);
  EXPECT_EQ(reply.in_force().scene().detector().threshold(), 77);
  EXPECT_EQ(fixture.next_scene().scene.detector.threshold, 77);
  EXPECT_EQ(watcher.next(Body::kScene).scene().revision(), 2U);
}

TEST(Stream, KeepsTheRevisionIfNothingChanges) {
  ServerFixture fixture;
  TestDisplay client(fixture.endpoint());
  EXPECT_EQ(client.change(threshold(Scene{}.detector.threshold)).in_force().revision(), 1U);
  EXPECT_FALSE(fixture.has_scene());
}

TEST(Stream, RefusesValuesOutOfRangeAndGoesOn) {
  ServerFixture fixture;
  TestDisplay client(fixture.endpoint());
  for (const double value :
       {-1.0, 256.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const auto reply = client.change(threshold(value));
    ASSERT_TRUE(reply.has_refused()) << value;
    EXPECT_NE(reply.refused().message().find("expected a number from 0 to 255"), std::string::npos)
        << reply.refused().message();
  }
  v1::Scene half_good = threshold(50);
  half_good.mutable_filter()->set_size(4);
  EXPECT_TRUE(client.change(half_good).has_refused());
  EXPECT_FALSE(fixture.has_scene()) << "a part of a refused change was applied";
  EXPECT_TRUE(client.change(threshold(50)).has_in_force());
  EXPECT_EQ(fixture.counters().scene_refusals.value(), 5U);
}

TEST(Stream, RefusesMalformedMessagesAndGoesOn) {
  ServerFixture fixture;
  TestDisplay client(fixture.endpoint());
  TestDisplay bystander(fixture.endpoint());
  bystander.next(Body::kHello);
  for (const std::string& bytes :
       {std::string("\xFF\xFF\xFF\xFF"), std::string("\x0A"), std::string(300, '\x07'), std::string()}) {
    client.send_bytes(bytes);
    EXPECT_NE(client.next(Body::kError).error().message().find("expected"), std::string::npos);
  }
  client.send_bytes("hello", false);
  EXPECT_NE(client.next(Body::kError).error().message().find("binary"), std::string::npos);
  EXPECT_TRUE(client.change(threshold(50)).has_in_force());
  EXPECT_EQ(fixture.counters().messages_refused.value(), 5U);
  EXPECT_EQ(bystander.next(Body::kScene).scene().revision(), 2U);
}

TEST(Stream, RefusesAndClosesDisplaysThatSendTooMuch) {
  ServerFixture fixture;
  TestDisplay bystander(fixture.endpoint());
  bystander.next(Body::kHello);
  TestDisplay client(fixture.endpoint());
  client.send_bytes(std::string(100'000, 'x'));
  EXPECT_NE(client.next(Body::kError).error().message().find("expected at most 65536"), std::string::npos);
  EXPECT_THROW(for (;;) client.next(), system_error);
  EXPECT_EQ(client.close_code(), 1009);

  TestDisplay flooder(fixture.endpoint());
  EXPECT_THROW(
      {
        flooder.send_bytes(std::string(8 << 20, 'x'));
        for (;;) flooder.next();
      },
      system_error);
  fixture.show(3, 90);
  EXPECT_EQ(bystander.next(Body::kPicture).picture().picture_id(), 3U);
}

TEST(Stream, ASlowDisplayLosesPicturesOfItsOwnOnly) {
  ServerFixture fixture(StreamServer::Config{}, "running", ServerFixture::kNoiseSize);
  TestDisplay slow(fixture.endpoint());
  slow.next(Body::kHello);
  TestDisplay quick(fixture.endpoint());
  quick.next(Body::kHello);
  // At most twice the bytes that the two socket buffers of Linux hold while the reader does not read (4 and 6
  // MB). The loop ends at the first skipped picture: 5 s after the buffers are full, the server ends the
  // connection.
  constexpr std::uint64_t kMostPictures = 40;
  std::uint64_t shown = 0;
  while (shown < kMostPictures && fixture.counters().pictures_skipped.value() == 0) {
    fixture.show_noise(++shown);
    while (quick.next(Body::kPicture).picture().picture_id() < shown) {
    }
  }
  EXPECT_GT(fixture.counters().pictures_skipped.value(), 0U)
      << "the slow display never fell behind: show more pictures";

  // When it reads again, it receives the messages under way and then the newest picture.
  std::uint64_t last = 0;
  std::uint64_t received = 0;
  while (last < shown) {
    const auto id = slow.next(Body::kPicture).picture().picture_id();
    EXPECT_GT(id, last);
    last = id;
    ++received;
  }
  const auto statistics = slow.next(Body::kStatistics).statistics();
  EXPECT_EQ(statistics.pictures_offered(), shown);
  EXPECT_EQ(statistics.pictures_sent(), received);
  EXPECT_EQ(statistics.pictures_offered(), statistics.pictures_sent() + statistics.pictures_skipped());
}

TEST(Stream, AnswersTheClock) {
  ServerFixture fixture;
  TestDisplay client(fixture.endpoint());
  v1::ClientMessage request;
  request.mutable_clock_request()->set_client_time_ms(1234.5);
  const std::int64_t before_ns = now_ns();
  client.send(request);
  const auto reply = client.next(Body::kClockReply).clock_reply();
  EXPECT_EQ(reply.client_time_ms(), 1234.5);
  EXPECT_GE(reply.server_time_ns(), before_ns);
  EXPECT_LE(reply.server_time_ns(), now_ns());
}

TEST(Stream, SurvivesDisplaysThatVanish) {
  ServerFixture fixture;
  for (std::uint64_t round = 1; round <= 50; ++round) {
    TestDisplay client(fixture.endpoint());
    client.next(Body::kHello);
    fixture.show(round, 1);
    client.vanish();
  }
  TestDisplay last(fixture.endpoint());
  fixture.show(1000, 1);
  while (last.next(Body::kPicture).picture().picture_id() != 1000) {
  }
  while (last.next(Body::kStatistics).statistics().sessions() > 1) {
  }
  const ServerCounters& counters = fixture.counters();
  EXPECT_EQ(counters.sessions_opened.value(), 51U);
  EXPECT_EQ(counters.sessions_closed.value(), 50U);
  EXPECT_EQ(counters.pictures_sent.value() + counters.pictures_skipped.value(),
            counters.pictures_offered.value());
}

TEST(Stream, RefusesAPageOfAnotherSite) {
  ServerFixture fixture;
  const std::string own = "http://127.0.0.1:" + std::to_string(fixture.endpoint().port());
  EXPECT_NO_THROW(TestDisplay(fixture.endpoint(), own));
  EXPECT_THROW(TestDisplay(fixture.endpoint(), "http://elsewhere.example"), system_error);
}

TEST(Stream, ClosesConnectionsBeyondTheLimit) {
  ServerFixture fixture(2);
  TestDisplay first(fixture.endpoint());
  {
    TestDisplay second(fixture.endpoint());
    second.next(Body::kHello);
    EXPECT_THROW(TestDisplay(fixture.endpoint()), system_error);
    second.close();
  }
  // The permit is free when the server has processed the close.
  for (bool open = false; !open;) {
    try {
      TestDisplay third(fixture.endpoint());
      open = third.next().has_hello();
    } catch (const system_error&) {
    }
  }
  EXPECT_GE(fixture.counters().connections_refused.value(), 1U);
}

TEST(Stream, ADisplayThatClosesHalfOfItsConnectionReturnsItsPermit) {
  ServerFixture fixture(StreamServer::Config{.most_connections = 2}, "running", ServerFixture::kNoiseSize);
  TestDisplay half(fixture.endpoint());
  half.next(Body::kHello);
  TestDisplay quick(fixture.endpoint());
  // More bytes than the socket holds, so that a write never ends. The other display shows that the server has
  // offered each picture.
  constexpr std::uint64_t kPictures = 40;
  for (std::uint64_t id = 1; id <= kPictures; ++id) {
    fixture.show_noise(id);
    while (quick.next(Body::kPicture).picture().picture_id() < id) {
    }
  }
  half.close_half();
  // Statistics come once a second; the server gives up a display after five seconds without progress.
  for (int seconds = 0; seconds < 60 && fixture.counters().sessions_closed.value() == 0; ++seconds) {
    quick.next(Body::kStatistics);
  }
  ASSERT_EQ(fixture.counters().sessions_closed.value(), 1U);
  TestDisplay next(fixture.endpoint());
  next.next(Body::kHello);
}

/// Reads until the server closes, and returns the code of its close frame.
std::uint16_t code_at_the_end(TestDisplay& display) {
  try {
    for (;;) display.next();
  } catch (const boost::system::system_error&) {
    return display.close_code();
  }
}

TEST(Stream, EndsADisplayThatPingsWithoutEnd) {
  ServerFixture fixture;
  TestDisplay noisy(fixture.endpoint());
  TestDisplay quiet(fixture.endpoint());
  for (int ping = 0; ping < InputBudget::kPingsPerSecond / 2; ++ping) quiet.ping();
  // Over the limit of whatever seconds it falls into.
  for (int ping = 0; ping < 10 * InputBudget::kPingsPerSecond; ++ping) noisy.ping();
  EXPECT_EQ(code_at_the_end(noisy), 1008);
  quiet.next(Body::kStatistics);
  quiet.next(Body::kStatistics);
  EXPECT_EQ(fixture.counters().sessions_closed.value(), 1U);
}

TEST(SceneStore, AppliesEachFieldAlone) {
  Doorbell bell;
  Mailbox<NumberedScene> scenes(bell);
  for (const SceneField& field : scene_fields()) {
    if (field.is_text()) continue;
    SceneStore store({.revision = 1, .scene = {}}, {}, scenes);
    const double now = field.get({});
    const double other = now + (field.step > 0 ? field.step : 0.25) > field.maximum
                             ? now - (field.step > 0 ? field.step : 0.25)
                             : now + (field.step > 0 ? field.step : 0.25);
    v1::Scene change;
    put_change(change, field, other);
    const auto applied = store.apply(change);
    ASSERT_TRUE(applied) << field.name << ": " << applied.error().message;
    EXPECT_TRUE(*applied) << field.name << " was dropped";
    EXPECT_EQ(store.in_force().revision, 2U) << field.name;
  }
}

TEST(Stream, PassesTheSurfaceThatTheRendererFindsToWhoAsked) {
  ServerFixture fixture;
  TestDisplay asker(fixture.endpoint());
  TestDisplay other(fixture.endpoint());
  other.next(Body::kHello);
  v1::ClientMessage message;
  message.mutable_survey()->set_request_id(42);
  asker.send(message);
  fixture.answer_survey([](Scene scene) {
    EXPECT_EQ(scene.camera.yaw_deg, 0);
    scene.camera.yaw_deg = 25;
    return FoundSurface{.scene = scene, .choices = {"a sheet of 80 x 60 mm"}};
  });
  const v1::SurveyReply reply = asker.next(Body::kSurveyReply).survey_reply();
  EXPECT_EQ(reply.request_id(), 42U);
  EXPECT_EQ(reply.found().scene().camera().yaw_deg(), 25);
  ASSERT_EQ(reply.found().choices_size(), 1);
  EXPECT_EQ(reply.found().choices(0), "a sheet of 80 x 60 mm");
  EXPECT_FALSE(fixture.has_scene()) << "nothing changes before the display says so";

  other.send(message);
  fixture.answer_survey([](const Scene&) { return std::nullopt; });
  EXPECT_NE(other.next(Body::kSurveyReply).survey_reply().refused().message().find("no surface"),
            std::string::npos);
}

TEST(Stream, LooksOnceForAllWhoAskMeanwhileAndRefusesACrowd) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  v1::ClientMessage message;
  for (std::uint64_t id = 1; id <= SurveyDesk::kMostRequests + 1; ++id) {
    message.mutable_survey()->set_request_id(id);
    display.send(message);
  }
  EXPECT_NE(display.next(Body::kSurveyReply).survey_reply().refused().message().find("wait for the surface"),
            std::string::npos);
  fixture.answer_volume_order(nullptr);
  EXPECT_EQ(display.next(Body::kSurveyReply).survey_reply().request_id(), 1U);
  fixture.answer_volume_order(nullptr);
  for (std::uint64_t id = 2; id <= SurveyDesk::kMostRequests; ++id)
    EXPECT_EQ(display.next(Body::kSurveyReply).survey_reply().request_id(), id);
}

TEST(Stream, EndsWithTheErrorOfTheRenderer) {
  ServerFixture fixture;
  fixture.fail({ErrorCode::kBroken, "the GPU is gone"});
  const auto end = fixture.wait_for_end();
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().message, "the GPU is gone");
}

TEST(Stream, EndsWithAnErrorWhereTheDriverDoesNotReturn) {
  StreamServer::Config config;
  config.most_driver_ms = 2'000;
  ServerFixture fixture(config);
  fixture.set_turn_began_ns(now_ns());
  const auto end = fixture.wait_for_end();
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().message,
            "a call of the GPU's driver has not returned for 2 s; expected a driver that answers");
}

TEST(Stream, ReportsWhyItCannotListen) {
  ServerFixture fixture;
  Doorbell bell;
  RenderLink link(bell, bell);
  const AcquisitionCounters acquisition;
  const RingCounters ring;
  const QueueCounters feed;
  const RenderCounters render;
  ProbeLink probe(bell, bell);
  ReplayLink replay(bell);
  ServerCounters counters;
  const auto second = StreamServer::create(
      {.endpoint = fixture.endpoint(), .state = {}},
      {.ports = {.render = link,
                 .probe = probe,
                 .replay = replay,
                 .counters = {acquisition, ring, feed, render, probe.counters, probe.igtl},
                 .source_state = {}},
       .counters = counters});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(second.error().message.find("in use"), std::string::npos) << second.error().message;
}

}  // namespace
}  // namespace fanlight::test
