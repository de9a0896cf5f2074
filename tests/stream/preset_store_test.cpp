// SPDX-License-Identifier: Apache-2.0
#include "server/state/preset_store.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "server/state/scene_message.hpp"
#include "tests/support/server_fixture.hpp"
#include "tests/support/test_display.hpp"

namespace fanlight::test {
namespace {

using Body = v1::ServerMessage;

const PresetStore::Author kOperator{.name = "Ann"};
const PresetStore::Author kAdmin{.name = "Root", .is_admin = true};

v1::Scene threshold(double level) {
  v1::Scene scene;
  scene.mutable_detector()->set_threshold(level);
  return scene;
}

std::string refusal(const Result<void>& result) {
  return result ? "" : result.error().message;
}

class PresetStoreTest : public testing::Test {
 protected:
  ~PresetStoreTest() override { std::filesystem::remove(file_); }
  std::string loads(const std::string& text) {
    std::ofstream(file_) << text;
    PresetStore store;
    const auto troubles = store.load(file_);
    return troubles.empty() ? "" : troubles.front();
  }

  const std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("presets_" + std::to_string(getpid()) + ".json");
  int changes_ = 0;
  PresetStore store_{[this] { ++changes_; }};
};

TEST_F(PresetStoreTest, SavesWhatThePictureShowsAndHowButNotTheView) {
  v1::Scene scene = threshold(44);
  scene.mutable_camera()->set_yaw_deg(30);
  scene.mutable_crop()->set_near_mm(10);
  scene.mutable_light()->set_right_mm(7);
  ASSERT_EQ(refusal(store_.save("my face", scene, kOperator)), "");
  const v1::Scene& saved = store_.all().at(0).scene;
  EXPECT_EQ(saved.detector().threshold(), 44);
  EXPECT_EQ(saved.light().right_mm(), 7);
  EXPECT_FALSE(saved.has_camera());
  EXPECT_FALSE(saved.has_crop());
  EXPECT_EQ(store_.message().saved(0).preset().help(), "saved by Ann");
  ASSERT_EQ(refusal(store_.save("my face", threshold(45), kOperator)), "") << "in its place";
  EXPECT_EQ(store_.all().size(), 1U);
  ASSERT_EQ(refusal(store_.save("a thigh", threshold(1), kOperator)), "");
  EXPECT_EQ(store_.all().at(0).name, "a thigh") << "in the order of names";
  EXPECT_EQ(changes_, 3);
}

TEST_F(PresetStoreTest, KeepsWhatIsCutAwayOnlyIfThatIsWanted) {
  v1::Scene scene = threshold(44);
  scene.mutable_cuts()->set_shapes("balls 6 at 1 2 3");
  ASSERT_EQ(refusal(store_.save("without", scene, kOperator)), "");
  v1::PresetRequest request;
  request.mutable_save()->set_name("with");
  request.set_with_cuts(true);
  ASSERT_EQ(refusal(store_.request(request, scene, kOperator)), "");
  ASSERT_EQ(store_.all().size(), 2U);
  EXPECT_EQ(store_.all()[0].scene.cuts().shapes(), "balls 6 at 1 2 3");
  EXPECT_FALSE(store_.all()[1].scene.has_cuts());
  EXPECT_EQ(loads(store_.json()), "");
  PresetStore read;
  EXPECT_TRUE(read.load(file_).empty());
  EXPECT_EQ(read.all()[0].scene.cuts().shapes(), "balls 6 at 1 2 3");
}

TEST_F(PresetStoreTest, RefusesNamesAndValues) {
  const std::string needs =
      "a preset needs a name of 1 to 40 characters, without control characters, or spaces at its ends";
  for (const std::string name : {"", " ", " a", "a ", "a\nb"})
    EXPECT_EQ(refusal(store_.save(name, threshold(1), kOperator)), needs);
  EXPECT_EQ(refusal(store_.save(std::string(41, 'a'), threshold(1), kOperator)), needs);
  EXPECT_EQ(refusal(store_.save("bone", threshold(1), kOperator)),
            "bone is a built-in preset, expected another name");
  EXPECT_EQ(refusal(store_.save("Bone", threshold(1), kOperator)),
            "Bone is a built-in preset, expected another name");
  EXPECT_NE(refusal(store_.save("x", threshold(999), kOperator)), "");
  v1::Scene view;
  view.mutable_camera()->set_yaw_deg(3);
  EXPECT_NE(refusal(store_.save("x", view, kOperator)).find("no field of a preset"), std::string::npos);
  EXPECT_EQ(refusal(store_.remove("x", kOperator)), "there is no saved preset x, expected the name of one");
  EXPECT_EQ(changes_, 0);
}

TEST_F(PresetStoreTest, AnAdminsPresetIsTheAdmins) {
  ASSERT_TRUE(store_.save("ward", threshold(50), kAdmin));
  const std::string refused =
      "an admin has saved the preset ward, expected an admin to change it, or another name";
  EXPECT_EQ(refusal(store_.save("ward", threshold(51), kOperator)), refused);
  EXPECT_EQ(refusal(store_.remove("ward", kOperator)), refused);
  EXPECT_EQ(refusal(store_.remove("ward", kAdmin)), "");
}

TEST_F(PresetStoreTest, HoldsAHundred) {
  for (std::size_t i = 0; i < PresetStore::kMost; ++i)
    ASSERT_TRUE(store_.save(std::to_string(i), threshold(1), kAdmin));
  EXPECT_EQ(refusal(store_.save("more", threshold(1), kAdmin)),
            "there are 100 presets already, expected one to be removed first");
  EXPECT_EQ(refusal(store_.save("7", threshold(2), kAdmin)), "");
}

TEST_F(PresetStoreTest, ReadsWhatItHasWritten) {
  ASSERT_TRUE(store_.save("ward \"quoted\"", threshold(50), kAdmin));
  ASSERT_TRUE(store_.save("Gesicht für Ärzte", scene_message(Scene{}), kOperator));
  std::ofstream(file_) << store_.json();
  PresetStore other;
  ASSERT_TRUE(other.load(file_).empty());
  EXPECT_EQ(other.json(), store_.json());
  EXPECT_TRUE(other.all().at(1).author.is_admin);
}

TEST_F(PresetStoreTest, RefusesAForeignFileAndReadsNothing) {
  PresetStore empty;
  EXPECT_TRUE(empty.load(file_).empty()) << "none is there";
  EXPECT_NE(loads("[]").find("it has no list of presets"), std::string::npos);
  EXPECT_NE(loads("{").find("it has no list of presets"), std::string::npos);
  EXPECT_NE(loads(R"({"presets": [3]})").find("an entry is no preset"), std::string::npos);
  EXPECT_NE(loads(R"({"presets": [{"name": "x", "scene": {"light": {"nope": 1}}}]})").find("the preset x"),
            std::string::npos);
  EXPECT_NE(loads(R"({"presets": [{"scene": {"mode": "surface"}}]})").find("needs a name"),
            std::string::npos);
}

TEST_F(PresetStoreTest, LeavesOutWhatALaterVersionCannotUse) {
  std::ofstream(file_) << R"({"presets": [{"name": "a", "scene": {"mode": "surface"}},
    {"name": "bone", "scene": {"mode": "surface"}}, {"name": "b", "scene": {"gone": {"field": 1}}},
    {"name": "c", "scene": {"detector": {"threshold": 40}}}]})";
  const auto troubles = store_.load(file_);
  ASSERT_EQ(troubles.size(), 2U);
  EXPECT_NE(troubles[0].find("the preset bone: bone is a built-in preset"), std::string::npos);
  ASSERT_EQ(store_.all().size(), 2U);
  EXPECT_EQ(store_.all()[1].name, "c");
}

TEST(PresetStream, IsToldToAllAndSavedByOperators) {
  ServerFixture fixture;
  TestDisplay first(fixture.endpoint());
  TestDisplay second(fixture.endpoint());
  EXPECT_EQ(first.next(Body::kPresets).presets().saved_size(), 0);
  second.next(Body::kPresets);
  v1::ClientMessage message;
  message.mutable_preset()->set_request_id(5);
  message.mutable_preset()->mutable_save()->set_name("mine");
  first.send(message);
  const v1::PresetReply reply = first.next(Body::kPresetReply).preset_reply();
  EXPECT_EQ(reply.request_id(), 5U);
  EXPECT_TRUE(reply.done());
  EXPECT_EQ(second.next(Body::kPresets).presets().saved(0).preset().name(), "mine");
  message.mutable_preset()->set_remove("yours");
  second.send(message);
  EXPECT_NE(
      second.next(Body::kPresetReply).preset_reply().refused().message().find("there is no saved preset"),
      std::string::npos);
  EXPECT_EQ(fixture.counters().preset_refusals.value(), 1U);
  EXPECT_EQ(fixture.counters().scene_changes.value(), 0U);
}

}  // namespace
}  // namespace fanlight::test
