// SPDX-License-Identifier: Apache-2.0
// What is noted of a picture is what is read again.
#include "server/state/picture_note.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

class PictureNoteTest : public testing::Test {
 protected:
  EchoLevels read(const std::string& line) const {
    const auto path = folder_.path() / "x.pictures.jsonl";
    std::ofstream(path) << line << "\n";
    const auto notes = read_picture_notes(path);
    EXPECT_TRUE(notes) << notes.error().message;
    return notes ? notes->pictures.at(0).levels : EchoLevels{};
  }

  static std::string note_of(const EchoLevels& levels) {
    PictureStamp stamp;
    stamp.levels = levels;
    return picture_note(stamp, {64, 64}, {64, 64});
  }

  TemporaryFolder folder_;
};

TEST_F(PictureNoteTest, KeepsTheLevelsInForce) {
  const EchoLevels known{.fluid = 7, .tissue = 120, .noise = 18, .known = true};
  const EchoLevels flat{.fluid = 100, .tissue = 110, .noise = 18, .flat = true};
  EXPECT_EQ(read(note_of(known)), known);
  EXPECT_EQ(read(note_of(flat)), flat) << "their noise says what stands out from the speckle";
  EXPECT_EQ(read(note_of({})), EchoLevels{});
}

TEST_F(PictureNoteTest, KeepsTheSizeAndTheUsualOne) {
  std::ofstream(folder_.path() / "sizes.jsonl") << picture_note({}, {64, 48}, {64, 48}) << '\n'
                                                << picture_note({}, {128, 96}, {64, 48}) << '\n';
  const auto notes = read_picture_notes(folder_.path() / "sizes.jsonl");
  ASSERT_TRUE(notes) << notes.error().message;
  EXPECT_EQ(notes->pictures.at(0).size, notes->pictures.at(0).usual);
  EXPECT_EQ(notes->pictures.at(1).size, (PictureSize{128, 96}));
  EXPECT_EQ(notes->pictures.at(1).usual, (PictureSize{64, 48}));
}

TEST_F(PictureNoteTest, ReadsFlatFramesOfRecordingsBefore) {
  std::string line = note_of({.flat = true});
  const std::size_t begin = line.find("\"levels\":");
  const std::size_t end = line.find('}', begin);
  line.replace(begin, end + 1 - begin, R"("levels":{"flat":true})");
  EXPECT_EQ(read(line), EchoLevels{.flat = true});
}

}  // namespace
}  // namespace fanlight::test
