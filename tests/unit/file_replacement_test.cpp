// SPDX-License-Identifier: Apache-2.0
// Files are written whole or not at all.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cerrno>
#include <fstream>

#include "proto/base/file_replacement.hpp"
#include "proto/base/folder_beneath.hpp"
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

/// A folder with a link to a file and a link to a folder outside of it.
class BeneathTest : public testing::Test {
 protected:
  BeneathTest() {
    for (const char* const name : {"outputs/sub", "outside"})
      std::filesystem::create_directories(work_ / name);
    std::ofstream(work_ / "outside/precious") << "precious";
    std::filesystem::create_symlink(work_ / "outside/precious", outputs_ / "link.png");
    std::filesystem::create_directory_symlink(work_ / "outside", outputs_ / "away");
  }

  Result<void> write(const std::filesystem::path& name) const {
    return replace_file(outputs_ / name, "new", {.beneath = outputs_});
  }

  const TemporaryFolder work_;
  const std::filesystem::path outputs_ = work_ / "outputs";
};

TEST_F(BeneathTest, FilesAreWrittenAndReplaced) {
  for (const char* const name : {"a", "sub/b", "a"}) {
    const auto written = write(name);
    ASSERT_TRUE(written) << written.error().message;
    EXPECT_EQ(text_of(outputs_ / name), "new");
  }
}

TEST_F(BeneathTest, NoLinkIsFollowedOutOfTheFolder) {
  for (const char* const name : {"link.png", "away/precious", "away/new"}) {
    const auto written = write(name);
    ASSERT_FALSE(written) << name;
    EXPECT_NE(written.error().message.find("a symbolic link is on the way"), std::string::npos)
        << written.error().message;
  }
  EXPECT_EQ(text_of(work_ / "outside/precious"), "precious");
  EXPECT_EQ(files_in(work_ / "outside"), 1U);
}

TEST_F(BeneathTest, NothingAboveTheFolderIsWritten) {
  EXPECT_FALSE(write("../outside/precious"));
  EXPECT_FALSE(replace_file(work_ / "outside/precious", "new", {.beneath = outputs_}));
  EXPECT_EQ(text_of(work_ / "outside/precious"), "precious");
}

TEST_F(BeneathTest, TheFolderItselfMayBeALink) {
  const std::filesystem::path link = work_ / "to_outputs";
  std::filesystem::create_directory_symlink(outputs_, link);
  EXPECT_TRUE(replace_file(link / "a", "new", {.beneath = link}));
  EXPECT_EQ(text_of(outputs_ / "a"), "new");
}

TEST_F(BeneathTest, MissingFoldersAreMade) {
  FolderBeneath folder;
  EXPECT_EQ(folder.open(outputs_, outputs_ / "x/y/file", FolderBeneath::Missing::kFail), ENOENT);
  EXPECT_EQ(folder.open(outputs_, outputs_ / "x/y/file", FolderBeneath::Missing::kMake), 0);
  std::ofstream(folder.name()) << "text";
  EXPECT_EQ(text_of(outputs_ / "x/y/file"), "text");
  EXPECT_EQ(folder.open(outputs_, outputs_ / "away/z/file", FolderBeneath::Missing::kMake), ELOOP);
  EXPECT_EQ(files_in(work_ / "outside"), 1U);
}

}  // namespace
}  // namespace fanlight::test
