// SPDX-License-Identifier: Apache-2.0
// The audit log: each line has the hash of the one before it, and every other line is detected.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "server/access/audit_log.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

const Principal kSomebody{
    .role = Role::kOperator, .name = "theatre 3", .proof = "3f9a0c21", .address = "10.0.0.1:5"};

std::vector<std::string> lines_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

void write_lines(const std::filesystem::path& path, const std::vector<std::string>& lines) {
  std::ofstream file(path);
  for (const std::string& line : lines) file << line << "\n";
}

TEST(AuditLog, GoesOnWhereItWasLeft) {
  const TemporaryFolder folder;
  for (int run = 0; run < 3; ++run) {
    AuditLog log = AuditLog::open(folder / "log").value();
    EXPECT_EQ(log.lines(), 2U * static_cast<unsigned>(run));
    log.note(kSomebody, {.what = "login", .result = "done"});
    log.note(kSomebody, {.what = "scene_change", .session = 7, .result = "done"},
             {{"to", "\xFF not UTF-8 \n"}});
  }
  const auto summary = verify_audit_log(folder / "log");
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->lines, 6U);
  const auto lines = lines_of(folder / "log");
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_EQ(summary->newest_hash, hex(sha256(lines.back())));
  const auto line = nlohmann::json::parse(lines[1]);
  EXPECT_EQ(line["who"], "theatre 3");
  EXPECT_EQ(line["role"], "operator");
  EXPECT_EQ(line["session"], 7);
  EXPECT_EQ(line["follows"], hex(sha256(lines[0])));
}

TEST(AuditLog, ShowsAnyLineThatWasTouched) {
  const TemporaryFolder folder;
  {
    AuditLog log = AuditLog::open(folder / "log").value();
    for (int line = 0; line < 5; ++line) log.note(kSomebody, {.what = "login", .result = "done"});
  }
  const auto lines = lines_of(folder / "log");
  for (std::size_t at = 0; at + 1 < lines.size(); ++at) {
    auto changed = lines;
    changed[at].replace(changed[at].find("theatre"), 7, "Theatre");
    write_lines(folder / "changed", changed);
    EXPECT_FALSE(verify_audit_log(folder / "changed")) << at;
    auto missing = lines;
    missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(at));
    write_lines(folder / "missing", missing);
    EXPECT_FALSE(verify_audit_log(folder / "missing")) << at;
    auto doubled = lines;
    doubled.insert(doubled.begin() + static_cast<std::ptrdiff_t>(at), lines[at]);
    write_lines(folder / "doubled", doubled);
    EXPECT_FALSE(verify_audit_log(folder / "doubled")) << at;
  }
  auto cut = lines;
  cut.back() = cut.back().substr(0, 20);
  write_lines(folder / "cut", cut);
  const auto opened = AuditLog::open(folder / "cut");
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("line 5"), std::string::npos);
}

TEST(AuditLog, CountsWhatADiskHasNoRoomFor) {
  auto log = AuditLog::open("/dev/full");
  ASSERT_TRUE(log);
  log->note(kSomebody, {.what = "login", .result = "done"});
  EXPECT_EQ(log->lines(), 0U);
  EXPECT_EQ(log->lines_lost(), 1U);
}

TEST(AuditLog, IsNotFloodedByWhatAnybodyMayCause) {
  const TemporaryFolder folder;
  AuditLog log = AuditLog::open(folder / "log").value();
  for (int refusal = 0; refusal < 10'000; ++refusal)
    log.note_refusal(kSomebody, {.what = "login", .result = "refused"});
  EXPECT_LE(log.lines(), 20U);
  log.note(kSomebody, {.what = "scene_change", .result = "done"});
  log.second_passed();
  log.note_refusal(kSomebody, {.what = "login", .result = "refused"});
  const auto lines = lines_of(folder / "log");
  ASSERT_EQ(lines.size(), 23U);
  EXPECT_EQ(nlohmann::json::parse(lines[21])["details"]["unlisted"], 9980);
  EXPECT_TRUE(verify_audit_log(folder / "log"));
}

TEST(AuditLog, KeepsNothingWhereNobodyAskedForOne) {
  AuditLog none;
  none.note(kSomebody, {.what = "login", .result = "done"});
  EXPECT_EQ(none.lines(), 0U);
  EXPECT_EQ(none.lines_lost(), 0U);
}

}  // namespace
}  // namespace fanlight::test
