// SPDX-License-Identifier: Apache-2.0
// Measurements that the server keeps: the store, and what displays and scripts see of it.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "server/state/measurement_file.hpp"
#include "server/state/measurement_store.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/made_measurements.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using nlohmann::json;

TEST(MeasurementStore, AddsRenamesAndRemoves) {
  int changes = 0;
  MeasurementStore store([&changes] { ++changes; });
  ASSERT_TRUE(store.request(adding(distance(1))));
  ASSERT_TRUE(store.request(adding(fluid(2))));
  EXPECT_FALSE(store.request(adding(distance(1)))) << "there is one of this id";
  ASSERT_TRUE(store.request(adding(distance(0))));
  EXPECT_NE(store.all().at(2).measurement.id(), 0U) << "the server chooses one";
  v1::MeasurementRequest request;
  request.mutable_rename()->set_id(2);
  request.mutable_rename()->set_name("left ovary, Zyste");
  ASSERT_TRUE(store.request(request));
  EXPECT_EQ(store.all().at(1).measurement.name(), "left ovary, Zyste");
  request.mutable_rename()->set_name("a\nb");
  EXPECT_EQ(store.request(request).error().code, ErrorCode::kInvalidArgument);
  request.set_remove(1);
  ASSERT_TRUE(store.request(request));
  EXPECT_EQ(store.request(request).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(store.all().size(), 2U);
  request.set_remove_all(true);
  ASSERT_TRUE(store.request(request));
  EXPECT_TRUE(store.all().empty());
  EXPECT_EQ(changes, 6);
  EXPECT_FALSE(store.request({})) << "no wish";
}

TEST(MeasurementStore, RefusesWhatCannotBeShown) {
  using Change = std::function<void(v1::Measurement&)>;
  const std::vector<Change> changes = {
      [](auto& one) { one.set_name(""); },
      [](auto& one) { one.set_name("  "); },
      [](auto& one) { one.set_name(std::string(101, 'a')); },
      [](auto& one) { one.set_name("a\x1b[2J"); },
      [](auto& one) { one.set_place(std::string(1001, 'a')); },
      [](auto& one) { one.set_place("a\nb"); },
      [](auto& one) { one.set_kind(static_cast<v1::Measurement::Kind>(77)); },
      [](auto& one) { one.clear_figures(); },
      [](auto& one) {
        for (int i = 0; i < 8; ++i) *one.add_figures() = one.figures(0);
      },
      [](auto& one) { one.mutable_figures(0)->set_value(std::nan("")); },
      [](auto& one) { one.mutable_figures(0)->set_deviation(-1); },
      [](auto& one) { one.mutable_figures(0)->set_unit("\u202emm"); },
      [](auto& one) { one.mutable_points(0)->set_z_mm(std::numeric_limits<double>::infinity()); },
      [](auto& one) { one.mutable_points(0)->set_y_mm(1e6); },
      [](auto& one) { one.add_path()->set_x_mm(std::nan("")); },
      [](auto& one) { one.mutable_across()->set_x_mm(std::nan("")); },
      [](auto& one) {
        for (int i = 0; i < 1024; ++i) one.add_points();
      },
      [](auto& one) { one.set_first_frame_number(20); },
      [](auto& one) { one.set_first_frame_number(one.last_frame_number()); },
      [](auto& one) { one.mutable_points()->RemoveLast(); },
      [](auto& one) { one.add_points(); },
      [](auto& one) { one.set_kind(v1::Measurement::ANGLE); },
      [](auto& one) { one.set_kind(v1::Measurement::AREA); },
      [](auto& one) { one.set_kind(v1::Measurement::VOLUME); },
      [](auto& one) {
        one.set_kind(v1::Measurement::ANGLE);
        one.add_points();
        one.add_path();
      },
      [](auto& one) { one.set_captured_unix_ms(9'000'000'000'000'000'000); },
      [](auto& one) { one.mutable_figures(0)->set_value(1e300); },
      [](auto& one) { one.set_kind(v1::Measurement::FLUID); },
      [](auto& one) { *one.mutable_region() = fluid(1).region(); },
      [](auto& one) { one = fluid(1, 49); },
      [](auto& one) { one = fluid(1, 1); },
      [](auto& one) {
        one = fluid(1, 4);
        one.mutable_region()->set_rows(5);
      },
      [](auto& one) {
        one = fluid(1, 4);
        one.mutable_region()->set_step_mm(0);
      },
  };
  MeasurementStore store;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    v1::Measurement measurement = distance(1);
    changes[i](measurement);
    const auto added = store.request(adding(measurement));
    ASSERT_FALSE(added) << i;
    EXPECT_EQ(added.error().code, ErrorCode::kInvalidArgument) << i;
    EXPECT_NE(added.error().message.find("expected"), std::string::npos) << added.error().message;
  }
  EXPECT_TRUE(store.request(adding(distance(1))));
}

TEST(MeasurementStore, IsBounded) {
  MeasurementStore many;
  for (std::uint64_t id = 1; id <= MeasurementStore::kMost; ++id)
    ASSERT_TRUE(many.request(adding(distance(id))));
  EXPECT_EQ(many.request(adding(distance(999))).error().code, ErrorCode::kUnavailable);
  MeasurementStore large;
  std::uint64_t id = 0;
  while (large.request(adding(fluid(++id)))) ASSERT_LT(id, 100U);
  EXPECT_EQ(id, 1 + MeasurementStore::kMostBytes / fluid(1).ByteSizeLong());
  v1::MeasurementRequest request;
  request.set_remove(1);
  ASSERT_TRUE(large.request(request));
  EXPECT_TRUE(large.request(adding(fluid(id)))) << "there is room again";
}

TEST(MeasurementStore, SendsASessionWhatIsNewToIt) {
  MeasurementStore store;
  for (const std::uint64_t id : {1, 2, 3}) ASSERT_TRUE(store.request(adding(fluid(id))));
  ASSERT_TRUE(store.request(adding(distance(4))));
  std::set<std::uint64_t> got;
  std::uint64_t known = 0;
  for (bool more = true; more;) {
    const MeasurementStore::Part part = store.part_after(known);
    EXPECT_EQ(part.list.ids_size(), 4);
    EXPECT_LT(part.list.ByteSizeLong(), 128U << 10);
    ASSERT_GT(part.list.changed_size(), 0);
    for (const auto& each : part.list.changed()) EXPECT_TRUE(got.insert(each.id()).second) << "twice";
    known = part.revision;
    more = part.more;
  }
  EXPECT_EQ(got.size(), 4U);
  v1::MeasurementRequest request;
  request.mutable_rename()->set_id(2);
  request.mutable_rename()->set_name("new");
  ASSERT_TRUE(store.request(request));
  request.set_remove(3);
  ASSERT_TRUE(store.request(request));
  const MeasurementStore::Part part = store.part_after(known);
  ASSERT_EQ(part.list.changed_size(), 1);
  EXPECT_EQ(part.list.changed(0).name(), "new");
  EXPECT_EQ(part.list.ids_size(), 3);
  EXPECT_FALSE(part.more);
  EXPECT_EQ(store.part_after(part.revision).list.changed_size(), 0);
}

TEST(MeasurementStore, ReadsWhatItHasWritten) {
  MeasurementStore store;
  v1::Measurement all = distance(~std::uint64_t{0});
  all.set_name("Kopf \"BPD\" äöü");
  all.add_path()->set_y_mm(1.0 / 3);
  all.mutable_across()->set_z_mm(1);
  all.mutable_deviation_mm()->set_x_mm(0.1);
  all.set_captured_unix_ms(1'795'368'300'000);
  all.set_volume_id(7);
  all.set_run_id(~std::uint64_t{1});
  ASSERT_TRUE(store.request(adding(all)));
  ASSERT_TRUE(store.request(adding(fluid(2, 5))));
  MeasurementStore read;
  ReadMeasurements parsed = parse_measurements(measurement_file_text(store.file(0, 100)));
  EXPECT_TRUE(parsed.troubles.empty());
  ASSERT_TRUE(read.load(std::move(parsed.file)).empty());
  ASSERT_EQ(read.all().size(), 2U);
  EXPECT_EQ(read.all()[0].measurement.SerializeAsString(), all.SerializeAsString()) << "every bit";
  const json overview = json::parse(read.overview());
  EXPECT_EQ(overview.at("measurements").at(1).at("region").at("depths"), "");
  EXPECT_EQ(overview.at("with_recording"), false);
}

TEST(MeasurementStore, WritesTheMeasurementsOfARecordingOnly) {
  MeasurementStore store;
  ASSERT_TRUE(store.request(adding(distance(1, 10, 19))));
  ASSERT_TRUE(store.request(adding(distance(2, 20, 29))));
  const auto ids = [&store](std::uint64_t first, std::uint64_t last) {
    const v1::MeasurementFile file = store.file(first, last);
    std::vector<std::uint64_t> found;
    for (const auto& each : file.measurements()) found.push_back(each.id());
    return found;
  };
  EXPECT_EQ(ids(10, 29), (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(ids(11, 29), (std::vector<std::uint64_t>{2})) << "a volume that is not whole in it";
  EXPECT_EQ(ids(11, 28), std::vector<std::uint64_t>{});
  EXPECT_EQ(store.signature(11, 28), 0U);
  EXPECT_NE(store.signature(10, 29), store.signature(11, 29));
}

TEST(MeasurementStream, IsKeptForAllDisplays) {
  ServerFixture fixture;
  TestDisplay first(fixture.endpoint());
  TestDisplay second(fixture.endpoint());
  EXPECT_EQ(first.next(v1::ServerMessage::kMeasurements).measurements().ids_size(), 0);
  second.next(v1::ServerMessage::kMeasurements);
  v1::MeasurementRequest request = adding(distance(5));
  request.set_request_id(3);
  first.send(sent(request));
  EXPECT_TRUE(first.next(v1::ServerMessage::kMeasurementReply).measurement_reply().done());
  for (TestDisplay* display : {&first, &second}) {
    const v1::MeasurementList list = display->next(v1::ServerMessage::kMeasurements).measurements();
    ASSERT_EQ(list.changed_size(), 1);
    EXPECT_EQ(list.changed(0).SerializeAsString(), distance(5).SerializeAsString());
    EXPECT_FALSE(list.with_recording());
    EXPECT_EQ(list.trouble(), "");
  }
  TestDisplay third(fixture.endpoint());
  EXPECT_EQ(third.next(v1::ServerMessage::kMeasurements).measurements().changed_size(), 1)
      << "who comes later";
  request.set_remove(77);
  second.send(sent(request));
  EXPECT_NE(second.next(v1::ServerMessage::kMeasurementReply)
                .measurement_reply()
                .refused()
                .message()
                .find("no measurement"),
            std::string::npos);
  EXPECT_EQ(fixture.counters().measurement_refusals.value(), 1U);
  request.set_remove(5);
  second.send(sent(request));
  EXPECT_EQ(first.next(v1::ServerMessage::kMeasurements).measurements().ids_size(), 0);
}

TEST(MeasurementStream, TakesTheRegionThatTheServerHasFound) {
  ServerFixture fixture;
  TestDisplay display(fixture.endpoint());
  CineStatus frozen;
  frozen.state = CineStatus::State::kFrozen;
  frozen.volume_id = 7;
  fixture.report_cine(frozen);
  while (display.next(v1::ServerMessage::kCine).cine().volume_id() != 7) continue;
  v1::Measurement measurement = fluid(1);
  measurement.clear_region();
  v1::MeasurementRequest request = adding(measurement);
  request.set_with_region(true);
  display.send(sent(request));
  EXPECT_NE(display.next(v1::ServerMessage::kMeasurementReply)
                .measurement_reply()
                .refused()
                .message()
                .find("region: expected"),
            std::string::npos)
      << "nothing was found yet";
  v1::ClientMessage question;
  question.mutable_fluid()->set_volume_id(7);
  question.mutable_fluid()->set_x_mm(1000);
  display.send(question);
  fixture.answer_fluid(7);
  const v1::FluidReply found = display.next(v1::ServerMessage::kFluidReply).fluid_reply();
  display.send(sent(request));
  EXPECT_TRUE(display.next(v1::ServerMessage::kMeasurementReply).measurement_reply().done());
  const v1::MeasurementList list = display.next(v1::ServerMessage::kMeasurements).measurements();
  ASSERT_EQ(list.changed_size(), 1);
  EXPECT_EQ(list.changed(0).region().SerializeAsString(), found.found().SerializeAsString());
}

TEST(MeasurementRest, ReadsAndChanges) {
  ServerFixture fixture;
  const auto count = [](const Answer& answer) { return json::parse(answer.body).at("measurements").size(); };
  EXPECT_EQ(count(talk(fixture, "GET", "/api/measurements")), 0U);
  const std::string added =
      R"({"add": {"name": "BPD", "kind": "DISTANCE", "points": [{"x_mm": 1}, {"x_mm": 3}],
          "first_frame_number": 0, "last_frame_number": 9, "figures": [{"name": "straight", "value": 2, "unit": "mm", "deviation": 0.1}]}})";
  const Answer answer = talk(fixture, "POST", "/api/measurements", added);
  ASSERT_EQ(answer.status, 200) << answer.body;
  const std::string id = json::parse(answer.body)["id"];
  const auto only = [&fixture] {
    const json list = json::parse(talk(fixture, "GET", "/api/measurements").body)["measurements"];
    EXPECT_EQ(list.size(), 1U);
    return list[0];
  };
  const json one = only();
  EXPECT_EQ(one["id"], id);
  EXPECT_EQ(one["kind"], "DISTANCE");
  EXPECT_EQ(one["points"][1]["x_mm"], 3);
  const std::string renamed = R"({"rename": {"id": ")" + id + R"(", "name": "HC"}})";
  EXPECT_EQ(json::parse(talk(fixture, "POST", "/api/measurements", renamed).body)["id"], id);
  EXPECT_EQ(only()["name"], "HC");
  EXPECT_EQ(talk(fixture, "POST", "/api/measurements", R"({"remove": "1"})").status, 404);
  for (const char* const malformed : {"{", "[]", "{}", R"({"add": 3})", R"({"wish": "add"})",
                                      R"({"remove_all": false})", R"({"add": {"kind": "FUTURE"}})"})
    EXPECT_EQ(talk(fixture, "POST", "/api/measurements", malformed).status, 400) << malformed;
  EXPECT_NE(
      talk(fixture, "POST", "/api/measurements", R"({"add": {"kind": "FUTURE"}})").body.find("add.kind"),
      std::string::npos)
      << "the field";
  EXPECT_EQ(talk(fixture, "POST", "/api/measurements", R"({"remove_all": true})").status, 200);
  EXPECT_EQ(count(talk(fixture, "GET", "/api/measurements")), 0U);
}

}  // namespace
}  // namespace fanlight::test
