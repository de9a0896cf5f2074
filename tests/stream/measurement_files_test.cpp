// SPDX-License-Identifier: Apache-2.0
// Measurements in files beside recordings.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "proto/model/measurement_file.hpp"
#include "server/service/saved_file.hpp"
#include "server/state/measurement_file.hpp"
#include "server/state/measurement_store.hpp"
#include "tests/support/http_talk.hpp"
#include "tests/support/made_measurements.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using nlohmann::json;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Waits up to 10 s, since another thread writes the file.
bool comes_to_hold(const std::filesystem::path& path, const std::string& text) {
  for (int i = 0; i < 1000; ++i) {
    if (text_of(path).find(text) != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

std::vector<std::uint64_t> ids_in(const std::filesystem::path& path) {
  std::vector<std::uint64_t> ids;
  const json file = json::parse(text_of(path));
  for (const auto& each : file.at("measurements"))
    ids.push_back(std::stoull(each.at("id").get<std::string>()));
  return ids;
}

TEST(MeasurementFile, CostsNoEntryForAnother) {
  for (const char* const foreign : {"", "{", "[]", "no JSON", R"({"presets": []})", R"({"measurements": 3})"})
    EXPECT_EQ(parse_measurements(foreign).troubles.size(), 1U) << foreign;
  EXPECT_EQ(parse_measurements(std::string(100'000, '[')).troubles.size(), 1U);
  MeasurementStore store;
  ASSERT_TRUE(store.request(adding(distance(2))));
  json file = json::parse(measurement_file_text(store.file(0, 100)));
  json later = file["measurements"][0];
  later["kind"] = "FUTURE";
  json damaged = file["measurements"][0];
  damaged["points"] = 3;
  json empty = file["measurements"][0];
  empty["id"] = "9";
  empty["figures"] = json::array();
  for (const json& each : {later, damaged, empty})
    file["measurements"].insert(file["measurements"].begin(), each);
  file["recording_bytes"] = "1234567890123456789";
  ReadMeasurements read = parse_measurements(file.dump());
  EXPECT_EQ(read.troubles.size(), 2U);
  EXPECT_EQ(read.file.recording_bytes(), 1'234'567'890'123'456'789U);
  MeasurementStore other;
  const auto troubles = other.load(std::move(read.file));
  ASSERT_EQ(troubles.size(), 1U);
  EXPECT_NE(troubles[0].find("the measurement 2: figures"), std::string::npos) << troubles[0];
  ASSERT_EQ(other.all().size(), 1U);
  EXPECT_EQ(other.all()[0].measurement.SerializeAsString(), distance(2).SerializeAsString());
}

TEST(MeasurementFile, IsReadOnlyWhereItIsAFileOfUsualSize) {
  const TemporaryFolder folder;
  const auto path = folder / "x.measurements.json";
  EXPECT_FALSE(read_measurement_file(path).value());
  std::ofstream(path) << "text";
  EXPECT_EQ(*read_measurement_file(path).value(), "text");
  std::filesystem::create_symlink(path, folder / "link");
  EXPECT_FALSE(read_measurement_file(folder / "link"));
  EXPECT_FALSE(read_measurement_file(folder.path()));
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  EXPECT_FALSE(read_measurement_file(folder / "fifo")) << "and does not wait";
  std::filesystem::resize_file(path, 20'000'001);
  EXPECT_FALSE(read_measurement_file(path));
}

TEST(MeasurementFile, OfAFullStoreCanBeReadAgain) {
  MeasurementStore store;
  v1::Measurement outline = distance(1);
  outline.set_kind(v1::Measurement::AREA);
  while (outline.points_size() < 1024) outline.add_points()->set_x_mm(-1234.0 / 7);
  for (std::uint64_t id = 1; store.request(adding(fluid(id))); ++id) continue;
  v1::MeasurementRequest request;
  request.set_remove(1);
  for (std::uint64_t id = 1; id < 15; ++id) {
    request.set_remove(id);
    ASSERT_TRUE(store.request(request));
  }
  for (std::uint64_t id = 1001;; ++id) {
    outline.set_id(id);
    if (!store.request(adding(outline))) break;
  }
  const std::string text = measurement_file_text(store.file(0, 100));
  EXPECT_LT(text.size(), 20'000'000U);
  EXPECT_GT(text.size(), 4'000'000U);
  EXPECT_TRUE(parse_measurements(text).troubles.empty());
}

TEST(SavedFileTest, AWritingThatEndsLateReplacesNothingNewer) {
  const TemporaryFolder folder;
  std::string state = "first";
  std::vector<std::function<void()>> late;
  SavedFile file(folder / "state",
                 {.name = "the state", .snapshot = [&state] { return [text = state] { return text; }; }},
                 [&late](EncoderLane, const std::function<void()>& work, const std::function<void()>&) {
                   late.push_back(work);
                 });
  file.changed();
  state = "second";
  file.changed();
  EXPECT_TRUE(file.is_busy());
  file.finish();
  EXPECT_EQ(text_of(folder / "state"), "second");
  ASSERT_EQ(late.size(), 1U) << "one at a time";
  late[0]();
  EXPECT_EQ(text_of(folder / "state"), "second");
}

class MeasurementFilesTest : public testing::Test {
 protected:
  /// A server that plays `path_`.
  std::unique_ptr<ServerFixture> plays() {
    StreamServer::Config config;
    config.state.description.path = path_.string();
    return std::make_unique<ServerFixture>(config);
  }
  static void keep(ServerFixture& fixture, const v1::Measurement& measurement) {
    TestDisplay display(fixture.endpoint());
    display.send(sent(adding(measurement)));
    const v1::MeasurementReply reply = display.next(v1::ServerMessage::kMeasurementReply).measurement_reply();
    ASSERT_TRUE(reply.done()) << reply.refused().message();
  }
  static v1::MeasurementList list_of(ServerFixture& fixture) {
    return TestDisplay(fixture.endpoint()).next(v1::ServerMessage::kMeasurements).measurements();
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "head.igs.mha";
  std::filesystem::path file_ = folder_ / "head.igs.mha.measurements.json";
};

TEST_F(MeasurementFilesTest, StayWithTheRecordingThatIsPlayed) {
  {
    const auto fixture = plays();
    EXPECT_TRUE(list_of(*fixture).with_recording());
    EXPECT_FALSE(std::filesystem::exists(file_)) << "nothing is written before something is measured";
    keep(*fixture, fluid(5, 30));
    EXPECT_TRUE(comes_to_hold(file_, "in plane A"));
    struct stat status {};
    ASSERT_EQ(stat(file_.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600U) << "as recordings are";
    keep(*fixture, distance(6));
  }
  EXPECT_EQ(ids_in(file_), (std::vector<std::uint64_t>{5, 6})) << "the last change is written at the end";
  const auto later = plays();
  const v1::MeasurementList list = list_of(*later);
  ASSERT_GE(list.changed_size(), 1);
  EXPECT_EQ(list.ids_size(), 2);
  EXPECT_EQ(list.changed(0).SerializeAsString(), fluid(5, 30).SerializeAsString());
  EXPECT_EQ(list.trouble(), "");
}

TEST_F(MeasurementFilesTest, APlaceThatCannotBeWrittenIsSaidWithoutItsPath) {
  std::ofstream(folder_ / "file") << "no folder";
  path_ = folder_ / "file" / "head.igs.mha";
  const auto fixture = plays();
  TestDisplay display(fixture->endpoint());
  display.next(v1::ServerMessage::kMeasurements);
  display.send(sent(adding(distance(1))));
  std::string trouble;
  while (trouble.empty()) trouble = display.next(v1::ServerMessage::kMeasurements).measurements().trouble();
  EXPECT_NE(trouble.find("until the server stops"), std::string::npos) << trouble;
  EXPECT_EQ(trouble.find("head"), std::string::npos) << trouble;
  EXPECT_EQ(list_of(*fixture).changed_size(), 1) << "kept nevertheless";
}

TEST_F(MeasurementFilesTest, AFileThatCannotBeReadKeepsAName) {
  std::ofstream(file_) << "{ someone's";
  const auto fixture = plays();
  EXPECT_NE(list_of(*fixture).trouble().find("can be read"), std::string::npos);
  EXPECT_EQ(list_of(*fixture).trouble().find("someone"), std::string::npos) << "nothing of its text";
  EXPECT_EQ(text_of(file_.string() + ".unread"), "{ someone's");
  EXPECT_EQ(text_of(file_), "{ someone's") << "not before there is something to write";
  keep(*fixture, distance(1));
  EXPECT_TRUE(comes_to_hold(file_, "in plane A"));
  EXPECT_EQ(text_of(file_.string() + ".unread"), "{ someone's");
  EXPECT_NE(list_of(*fixture).trouble().find("can be read"), std::string::npos) << "still so";
  // The next damage leaves the first copy.
  std::ofstream(file_) << "{ another's";
  const auto next = plays();
  EXPECT_EQ(text_of(file_.string() + ".unread"), "{ someone's");
  EXPECT_EQ(text_of(file_.string() + ".unread-2"), "{ another's");
}

TEST_F(MeasurementFilesTest, AFileThatAnotherServerHasChangedIsLeftAlone) {
  const auto one = plays();
  const auto other = plays();
  keep(*one, distance(1));
  EXPECT_TRUE(comes_to_hold(file_, "in plane A"));
  keep(*other, distance(2));
  for (int i = 0; i < 1000 && list_of(*other).trouble().empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_NE(list_of(*other).trouble().find("another program has changed"), std::string::npos);
  EXPECT_EQ(ids_in(file_), (std::vector<std::uint64_t>{1}));
}

TEST_F(MeasurementFilesTest, FollowNoSymbolicLink) {
  std::ofstream(folder_ / "precious") << "precious";
  std::filesystem::create_symlink(folder_ / "precious", file_);
  const auto fixture = plays();
  keep(*fixture, distance(1));
  for (int i = 0; i < 100 && list_of(*fixture).trouble().empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_NE(list_of(*fixture).trouble(), "");
  EXPECT_EQ(text_of(folder_ / "precious"), "precious");
}

TEST_F(MeasurementFilesTest, OfAnotherRecordingOfThatNameAreNotShown) {
  std::ofstream(path_) << "a recording";
  {
    const auto fixture = plays();
    keep(*fixture, distance(1));
    EXPECT_TRUE(comes_to_hold(file_, "in plane A"));
  }
  EXPECT_EQ(list_of(*plays()).ids_size(), 1) << "the same recording";
  std::ofstream(path_) << "another recording";
  const auto fixture = plays();
  EXPECT_EQ(list_of(*fixture).ids_size(), 0);
  EXPECT_NE(list_of(*fixture).trouble().find("another one of its name"), std::string::npos);
}

TEST_F(MeasurementFilesTest, OfARecordingThatHasEndedOutlastTheList) {
  StreamServer::Config config;
  config.state.recording.folder = folder_.path();
  auto fixture = std::make_unique<ServerFixture>(config);
  keep(*fixture, distance(1));
  fixture->report_recording({.finished = 1,
                             .last_file = path_.string(),
                             .last_file_first_sequence = 5,
                             .last_file_last_sequence = 25});
  EXPECT_TRUE(comes_to_hold(file_, "in plane A"));
  EXPECT_EQ(talk(*fixture, "POST", "/api/measurements", R"({"remove_all": true})").status, 200);
  keep(*fixture, distance(2));
  fixture.reset();
  EXPECT_EQ(ids_in(file_), (std::vector<std::uint64_t>{1}));
}

TEST_F(MeasurementFilesTest, StayWithRecordingsOfTheirVolume) {
  StreamServer::Config config;
  config.state.recording.folder = folder_.path();
  auto fixture = std::make_unique<ServerFixture>(config);
  keep(*fixture, distance(1, 10, 19));
  keep(*fixture, distance(2, 20, 29));
  // Two recordings end; the volume of measurement 1 is whole in the first of them.
  const auto one = folder_ / "one.igs.mha";
  const auto two = folder_ / "two.igs.mha";
  fixture->report_recording({.finished = 1,
                             .last_file = one.string(),
                             .last_file_first_sequence = 5,
                             .last_file_last_sequence = 25});
  EXPECT_TRUE(comes_to_hold(measurements_path_of(one), "in plane A"));
  EXPECT_EQ(ids_in(measurements_path_of(one)), (std::vector<std::uint64_t>{1}));
  // One of an earlier start counts frames of its own.
  fixture->report_recording({.finished = 2,
                             .last_file = (folder_ / "cut.igs.mha").string(),
                             .last_was_cut_off = true,
                             .last_file_first_sequence = 0,
                             .last_file_last_sequence = 99});
  // One is under way when the server ends.
  fixture->report_recording({.state = RecordingStatus::State::kRecording,
                             .file = two.string(),
                             .first_sequence = 15,
                             .last_sequence = 20,
                             .finished = 2,
                             .last_file = (folder_ / "cut.igs.mha").string(),
                             .last_was_cut_off = true});
  EXPECT_TRUE(comes_to_hold(measurements_path_of(two), "in plane A"));
  keep(*fixture, distance(3, 30, 39));
  fixture.reset();
  EXPECT_EQ(ids_in(measurements_path_of(two)), (std::vector<std::uint64_t>{2, 3}));
  EXPECT_EQ(ids_in(measurements_path_of(one)), (std::vector<std::uint64_t>{1}));
  EXPECT_FALSE(std::filesystem::exists(measurements_path_of(folder_ / "cut.igs.mha")));
}

}  // namespace
}  // namespace fanlight::test
