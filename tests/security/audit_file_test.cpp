// SPDX-License-Identifier: Apache-2.0
// The file of the audit log: what a power cut leaves, rotation, one writer, long logs.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "server/access/audit_chain.hpp"
#include "server/access/audit_entry.hpp"
#include "server/access/audit_file.hpp"
#include "server/access/digest.hpp"
#include "tests/support/file_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

std::string entry(const std::string& result = "done") {
  return audit_fields({.name = "theatre 3"}, {.what = "control", .result = result}, nullptr);
}

/// Opens the log, appends lines and closes it. Returns the notice.
std::string append(const std::filesystem::path& path, int lines, std::uint64_t rotate_bytes = 0) {
  auto file = AuditFile::open(path, rotate_bytes);
  if (!file) return "not opened: " + file.error().message;
  for (int line = 0; line < lines; ++line) EXPECT_EQ((*file)->append(entry()), 0);
  EXPECT_EQ((*file)->sync(), 0);
  return (*file)->take_notice();
}

std::vector<std::filesystem::path> files_of(const TemporaryFolder& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& one : std::filesystem::directory_iterator(folder.path())) files.push_back(one.path());
  return files;
}

TEST(AuditFile, GoesOnAfterALineThatWasTornAtAnyByte) {
  const TemporaryFolder folder;
  append(folder / "whole", 3);
  const std::string whole = text_of(folder / "whole");
  const std::size_t last_line = whole.rfind('\n', whole.size() - 2) + 1;
  for (std::size_t size = last_line + 1; size < whole.size(); size += 7) {
    const TemporaryFolder cut;
    std::ofstream(cut / "log", std::ios::binary) << whole.substr(0, size);
    const std::string notice = append(cut / "log", 1);
    EXPECT_NE(notice.find("log-torn-3"), std::string::npos) << size << ": " << notice;
    EXPECT_EQ(text_of(cut / "log-torn-3"), whole.substr(last_line, size - last_line));
    const auto summary = verify_audit_log(cut / "log");
    ASSERT_TRUE(summary) << size << ": " << summary.error().message;
    EXPECT_EQ(summary->lines, 4U);
    EXPECT_EQ(text_of(cut / "log").substr(0, last_line), whole.substr(0, last_line));
    const std::string said = text_of(cut / "log").substr(last_line);
    const auto line = nlohmann::json::parse(said.substr(0, said.find('\n')));
    EXPECT_EQ(line["what"], "audit");
    EXPECT_EQ(line["details"]["bytes"], size - last_line);
    EXPECT_EQ(line["details"]["sha256"], hex(sha256(whole.substr(last_line, size - last_line))));
  }
}

TEST(AuditFile, GoesOnAfterBytesThatTheFileSystemDidNotWrite) {
  const TemporaryFolder folder;
  append(folder / "log", 2);
  std::ofstream(folder / "log", std::ios::app | std::ios::binary) << std::string(300, '\0');
  EXPECT_NE(append(folder / "log", 1), "");
  EXPECT_EQ(verify_audit_log(folder / "log").value().lines, 4U);
}

TEST(AuditFile, IsWholeWhereItsServerWasKilledWhileItRotated) {
  const TemporaryFolder folder;
  append(folder / "log", 3);
  std::filesystem::create_hard_link(folder / "log", folder / "log.000000000003");
  std::ofstream(folder / "log.next") << "{\"line\":4,";
  const std::vector<std::filesystem::path> all = {folder / "log", folder / "log.000000000003",
                                                  folder / "log.next"};
  const auto summary = verify_audit_logs(all);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->lines, 3U);
  append(folder / "log", 1);
  EXPECT_EQ(verify_audit_logs(files_of(folder)).value().lines, 4U);
  EXPECT_EQ(files_of(folder).size(), 1U) << "the next start removes what was left";
}

TEST(AuditFile, LeavesAFileAloneThatIsNoLog) {
  const TemporaryFolder folder;
  for (const char* text : {"a letter without a line end", "a letter\n", "{\"line\":7,", "\n"}) {
    std::ofstream(folder / "letter") << text;
    EXPECT_FALSE(AuditFile::open(folder / "letter", 0)) << text;
    EXPECT_EQ(text_of(folder / "letter"), text);
  }
  EXPECT_EQ(files_of(folder).size(), 1U);
}

TEST(AuditFile, RefusesAnEndThatWasChanged) {
  const TemporaryFolder folder;
  append(folder / "log", 5);
  std::string text = text_of(folder / "log");
  text.replace(text.rfind("theatre"), 7, "Theatre");
  std::ofstream(folder / "log") << text << "{\"line\":6,\"follows\":\"00\"}\n";
  const auto opened = AuditFile::open(folder / "log", 0);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("line 6"), std::string::npos) << opened.error().message;
}

TEST(AuditFile, GoesOnWithALogOfVersion0_1_0) {
  const TemporaryFolder folder;
  // clang-format off
  const std::vector<std::string> lines = {
      R"({"line":1,"time":"2026-11-21T08:30:52.055Z","what":"session_opened","who":"loopback","role":"admin","proof":"","from":"127.0.0.1:37910","session":1,"result":"done","follows":"0000000000000000000000000000000000000000000000000000000000000000"})",
      R"({"line":2,"time":"2026-11-21T08:30:52.336Z","what":"scene_change","who":"loopback","role":"admin","proof":"","from":"127.0.0.1:37910","session":1,"result":"done","details":{"changes":1,"to":{"light":{"up_mm":20}}},"follows":"422d2cbf2b6789ac3e715579faad0dcaa60f2109c218964d5171da38f25e332c"})",
      R"({"line":3,"time":"2026-11-21T08:30:52.336Z","what":"session_closed","who":"loopback","role":"admin","proof":"","from":"127.0.0.1:37910","session":1,"result":"the display left","follows":"40f1a8ee44ed336f721483409e3df5461da71958b495c603a799e86a7b4690cb"})"};
  // clang-format on
  for (const std::string& line : lines) std::ofstream(folder / "log", std::ios::app) << line << "\n";
  EXPECT_EQ(verify_audit_log(folder / "log").value().lines, 3U);
  EXPECT_EQ(append(folder / "log", 2), "");
  EXPECT_EQ(verify_audit_log(folder / "log").value().lines, 5U);
}

TEST(AuditFile, GoesOnInANewFileWhenItWasRemoved) {
  const TemporaryFolder folder;
  auto file = AuditFile::open(folder / "log", 0).value();
  EXPECT_EQ(file->append(entry()), 0);
  std::filesystem::remove(folder / "log");
  EXPECT_EQ(file->sync(), 0);
  EXPECT_NE(file->take_notice().find("new file"), std::string::npos);
  EXPECT_EQ(file->append(entry()), 0);
  const auto summary = verify_audit_log(folder / "log");
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->first_line, 2U) << "what was removed is missed";
  EXPECT_EQ(summary->lines, 2U);
}

TEST(AuditFile, HasOneWriter) {
  const TemporaryFolder folder;
  {
    const auto first = AuditFile::open(folder / "log", 0);
    ASSERT_TRUE(first);
    const auto second = AuditFile::open(folder / "log", 0);
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find("another process"), std::string::npos);
  }
  EXPECT_TRUE(AuditFile::open(folder / "log", 0));
}

TEST(AuditFile, IsRotatedWithItsChain) {
  const TemporaryFolder folder;
  append(folder / "log", 40, 3000);
  auto files = files_of(folder);
  ASSERT_GE(files.size(), 4U);
  for (const auto& file : files) EXPECT_LT(std::filesystem::file_size(file), 4000U);
  const auto summary = verify_audit_logs(files);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->first_line, 1U);
  EXPECT_EQ(summary->lines, 40 + files.size() - 1) << "each new file begins with an entry of its own";
  const auto newest = verify_audit_log(folder / "log");
  ASSERT_TRUE(newest) << newest.error().message;
  EXPECT_GT(newest->first_line, 1U);
  EXPECT_EQ(newest->newest_hash, summary->newest_hash);

  append(folder / "log", 1, 3000);
  EXPECT_EQ(verify_audit_logs(files_of(folder)).value().lines, summary->lines + 1);

  std::ranges::sort(files);
  std::filesystem::remove(files[2]);  // after the newest and the oldest
  EXPECT_FALSE(verify_audit_logs(files_of(folder))) << "a file is missing";
}

TEST(AuditFile, GoesOnAfterARotationThatWasCutOff) {
  const TemporaryFolder folder;
  append(folder / "log", 3);
  std::filesystem::create_hard_link(folder / "log", folder / "log.000000000003");
  std::ofstream(folder / "log.next") << "{\"line\":4,";
  append(folder / "log", 20, 1500);
  EXPECT_FALSE(std::filesystem::exists(folder / "log.next"));
  EXPECT_GE(files_of(folder).size(), 2U);
  const auto summary = verify_audit_logs(files_of(folder));
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_GE(summary->lines, 23U);
}

TEST(AuditFile, ARotatedFileWithoutItsFirstLinesIsDetected) {
  const TemporaryFolder folder;
  append(folder / "log", 10);
  const std::string text = text_of(folder / "log");
  std::ofstream(folder / "log") << text.substr(text.find('\n') + 1);
  EXPECT_FALSE(verify_audit_log(folder / "log"));
}

TEST(AuditFile, GoesOnInANewFileWhenItWasMoved) {
  const TemporaryFolder folder;
  {
    auto file = AuditFile::open(folder / "log", 0).value();
    EXPECT_EQ(file->append(entry()), 0);
    file->reopen();
    EXPECT_EQ(file->take_notice(), "") << "nothing was moved";
    std::filesystem::rename(folder / "log", folder / "log.1");
    EXPECT_EQ(file->append(entry()), 0) << "to the file that was moved";
    file->reopen();
    EXPECT_NE(file->take_notice().find("new file"), std::string::npos);
    EXPECT_EQ(file->append(entry()), 0);
    EXPECT_FALSE(AuditFile::open(folder / "log", 0)) << "the new file is locked too";

    std::filesystem::rename(folder / "log", folder / "log.2");
    std::ofstream(folder / "log") << "something else\n";
    file->reopen();
    EXPECT_NE(file->take_notice().find("continues in the old one"), std::string::npos);
    EXPECT_EQ(file->append(entry()), 0);
    EXPECT_EQ(text_of(folder / "log"), "something else\n");
  }
  EXPECT_EQ(verify_audit_log(folder / "log.1").value().lines, 2U);
  const std::vector<std::filesystem::path> both = {folder / "log.2", folder / "log.1"};
  const auto summary = verify_audit_logs(both);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->lines, 5U);
}

TEST(AuditFile, ReadsTheEndOfALongLogOnly) {
  const TemporaryFolder folder;
  append(folder / "log", 1);
  // A hole of four gigabytes, which takes a minute or more to read as lines, and no room on the disk.
  constexpr std::uint64_t kHole = 4ULL << 30;
  const std::string line = text_of(folder / "log");
  std::filesystem::resize_file(folder / "log", kHole);
  std::ofstream(folder / "log", std::ios::app) << "\n" << line;
  auto file = AuditFile::open(folder / "log", 0);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ((*file)->position().line, 1U);
  EXPECT_EQ((*file)->append(entry()), 0);
  EXPECT_EQ((*file)->position().line, 2U);
}

TEST(AuditFile, IsItsOwnersAlone) {
  const TemporaryFolder folder;
  append(folder / "log", 40, 3000);
  for (const auto& file : files_of(folder)) {
    struct stat status {};
    ASSERT_EQ(stat(file.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0600U) << file;
  }
}

}  // namespace
}  // namespace fanlight::test
