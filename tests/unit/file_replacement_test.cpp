// SPDX-License-Identifier: Apache-2.0
// Files are written whole or not at all.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "proto/base/file_replacement.hpp"
#include "tests/support/file_size_limit.hpp"
#include "tests/support/file_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

mode_t mode_of(const std::filesystem::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_mode & 07777 : 0;
}

TEST(FileReplacement, WritesAndReplaces) {
  const TemporaryFolder folder;
  const std::string large(3'000'000, 'x');
  for (const std::string& text : {std::string("first"), large, std::string()}) {
    const auto written = replace_file(folder / "f", text);
    ASSERT_TRUE(written) << written.error().message;
    EXPECT_EQ(text_of(folder / "f"), text);
  }
  EXPECT_EQ(files_in(folder.path()), 1U);
}

TEST(FileReplacement, KeepsWhatWasThereWhereThereIsNoRoom) {
  const TemporaryFolder folder;
  ASSERT_TRUE(replace_file(folder / "f", "what was there"));
  const std::string large(100'000, 'x');
  {
    const FileSizeLimit limit(4096);
    const auto old = replace_file(folder / "f", large);
    ASSERT_FALSE(old);
    EXPECT_NE(old.error().message.find("could not be written"), std::string::npos);
    EXPECT_FALSE(replace_file(folder / "new", large));
  }
  EXPECT_EQ(text_of(folder / "f"), "what was there");
  EXPECT_EQ(files_in(folder.path()), 1U) << "nothing is left beside it";
}

TEST(FileReplacement, KeepsTheModeAndTheLink) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "other");
  ASSERT_TRUE(replace_file(folder / "other/f", "a", {.mode = 0600}));
  EXPECT_EQ(mode_of(folder / "other/f"), 0600U);
  chmod((folder / "other/f").c_str(), 0640);
  std::filesystem::create_symlink("other/f", folder / "link");
  ASSERT_TRUE(replace_file(folder / "link", "b", {.mode = 0600}));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_EQ(text_of(folder / "other/f"), "b");
  EXPECT_EQ(mode_of(folder / "other/f"), 0640U);
}

TEST(FileReplacement, WritesADeviceAsItStands) {
  const TemporaryFolder folder;
  EXPECT_TRUE(replace_file("/dev/null", "x"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  std::filesystem::create_symlink("/dev/full", folder / "full");
  EXPECT_FALSE(replace_file(folder / "full", "x"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "full"));
}

TEST(FileReplacement, SaysWhyItFailed) {
  const TemporaryFolder folder;
  const auto absent = replace_file(folder / "absent/f", "x");
  ASSERT_FALSE(absent);
  EXPECT_NE(absent.error().message.find("No such file"), std::string::npos) << absent.error().message;
  EXPECT_NE(absent.error().message.find("expected an existing, writable folder with room"),
            std::string::npos);
  EXPECT_FALSE(replace_file(folder.path(), "x")) << "a folder";
}

}  // namespace
}  // namespace fanlight::test
