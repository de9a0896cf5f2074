// SPDX-License-Identifier: Apache-2.0
// The audit log: each line has the hash of the one before it, and every other line is detected.
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "proto/base/printable.hpp"
#include "server/access/audit_budget.hpp"
#include "server/access/audit_log.hpp"
#include "tests/support/file_size_limit.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

const Principal kNurse{
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
    EXPECT_EQ(log.newest().line, 2U * static_cast<unsigned>(run));
    log.note(kNurse, {.what = "login", .result = "done"});
    log.note(kNurse, {.what = "scene_change", .session = 7, .result = "done"}, {{"to", "\xFF not UTF-8 \n"}});
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
    for (int line = 0; line < 5; ++line) log.note(kNurse, {.what = "login", .result = "done"});
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
  log->note(kNurse, {.what = "login", .result = "done"});
  ASSERT_TRUE(log->wait_until_written());
  EXPECT_EQ(log->newest().line, 0U);
  EXPECT_EQ(log->lines_lost(), 1U);
}

TEST(AuditLog, ShowsTheGapThatAFullDiskLeft) {
  const TemporaryFolder folder;
  AuditLog log = AuditLog::open(folder / "log").value();
  log.note(kNurse, {.what = "control", .result = "done"});
  ASSERT_TRUE(log.wait_until_written());
  {
    // Room for a part of a line.
    const FileSizeLimit limit(std::filesystem::file_size(folder / "log") + 20);
    for (int lost = 0; lost < 7; ++lost) log.note(kNurse, {.what = "control", .result = "done"});
    ASSERT_TRUE(log.wait_until_written());
    EXPECT_EQ(log.lines_lost(), 7U);
    EXPECT_EQ(lines_of(folder / "log").size(), 1U) << "no part of a line stays";
  }
  log.note(kNurse, {.what = "control", .result = "done"});
  ASSERT_TRUE(log.close());
  const auto lines = lines_of(folder / "log");
  ASSERT_EQ(lines.size(), 3U);
  const auto gap = nlohmann::json::parse(lines[1]);
  EXPECT_EQ(gap["what"], "audit");
  EXPECT_EQ(gap["result"], "lost");
  EXPECT_EQ(gap["details"]["count"], 7);
  const auto summary = verify_audit_log(folder / "log");
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->lost, 7U);
}

TEST(AuditLog, TellsOfAGapAlsoWhereNothingElseHappens) {
  const TemporaryFolder folder;
  AuditLog log = AuditLog::open(folder / "log").value();
  {
    const FileSizeLimit limit(0);
    log.note(kNurse, {.what = "control", .result = "done"});
    ASSERT_TRUE(log.wait_until_written());
  }
  for (int tries = 0; tries < 500 && log.newest().line == 0; ++tries)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(log.newest().line, 1U);
}

TEST(AuditLog, RefusalsUseUpNothingThatAnActNeeds) {
  const TemporaryFolder folder;
  AuditLog log = AuditLog::open(folder / "log").value();
  for (int refusal = 0; refusal < 10'000; ++refusal)
    log.note({.name = "unknown"}, {.what = "request", .result = "refused: from a page of another site"});
  for (int refusal = 0; refusal < 100; ++refusal)
    log.note(kNurse, {.what = "control", .result = "refused: another session is in control"});
  log.note(kNurse, {.what = "control", .session = 3, .result = "done"});
  ASSERT_TRUE(log.wait_until_written());
  auto lines = lines_of(folder / "log");
  ASSERT_EQ(lines.size(), 41U);
  EXPECT_EQ(nlohmann::json::parse(lines.back())["session"], 3);
  log.second_passed();
  log.note({.name = "unknown"}, {.what = "request", .result = "refused"});
  ASSERT_TRUE(log.close());
  lines = lines_of(folder / "log");
  ASSERT_EQ(lines.size(), 43U);
  EXPECT_EQ(nlohmann::json::parse(lines[41])["details"]["unlisted"], 9980 + 80);
  EXPECT_TRUE(verify_audit_log(folder / "log"));
}

TEST(AuditLog, CountsWhatItFolds) {
  const TemporaryFolder folder;
  AuditLog log = AuditLog::open(folder / "log").value();
  for (std::uint64_t session = 1; session <= 1000; ++session)
    log.note(kNurse, {.what = "session_opened", .session = session, .result = "done"});
  for (int change = 1; change <= 50; ++change)
    log.note(kNurse, {.what = "scene_change", .result = "done"}, {{"light.up_mm", change}});
  log.second_passed();
  ASSERT_TRUE(log.wait_until_written());
  const auto lines = lines_of(folder / "log");
  ASSERT_EQ(lines.size(), 20U + 20U + 2U);
  std::map<std::string, nlohmann::json> folded;
  for (const auto& text : {lines[40], lines[41]}) {
    const auto line = nlohmann::json::parse(text);
    EXPECT_EQ(line["result"], "folded");
    EXPECT_EQ(line["who"], "theatre 3");
    folded[line["what"]] = line["details"];
  }
  EXPECT_EQ(folded["session_opened"]["count"], 980);
  EXPECT_EQ(folded["scene_change"]["count"], 30);
  EXPECT_EQ(folded["scene_change"]["newest"]["light.up_mm"], 50);
}

TEST(AuditBudget, ManySessionsUseUpNothingThatAnotherOnesActNeeds) {
  AuditBudget budget;
  const auto act = [&](const char* what, const Principal& who, std::uint64_t session) {
    return budget.take(who, {.what = what, .session = session, .result = "done"}, nullptr);
  };
  std::size_t lines = 0;
  for (std::uint64_t session = 1; session <= 100'000; ++session) {
    if (act("private_view", kNurse, session)) ++lines;
  }
  EXPECT_LE(lines, AuditBudget::kMostBudgets + AuditBudget::kLinesASecond) << "and the memory is bounded";
  EXPECT_TRUE(act("control", {.role = Role::kAdmin, .name = "admin", .proof = "11112222", .address = ""}, 1));
  std::uint64_t folded = 0;
  for (const auto& one : budget.second_passed()) folded += one.count;
  EXPECT_EQ(folded, 100'000 - lines);
  EXPECT_TRUE(act("private_view", kNurse, 100'001)) << "a second later";
}

TEST(AuditBudget, PicturesThatAreReadHaveALineAMinute) {
  AuditBudget budget;
  const AuditEvent read{.what = "picture_read", .result = "done"};
  std::size_t lines = 0;
  std::uint64_t folded = 0;
  for (int second = 0; second < 120; ++second) {
    if (budget.take(kNurse, read, nullptr)) ++lines;
    for (const auto& one : budget.second_passed()) folded += one.count;
  }
  EXPECT_EQ(lines, 2U);
  EXPECT_EQ(folded, 118U);
}

TEST(AuditLog, HasPrintableTextOnly) {
  const TemporaryFolder folder;
  AuditLog log = AuditLog::open(folder / "log").value();
  log.note({.name = "a\xC2\x9B"
                    "31m\xE2\x80\xAE",
            .address = "\x9B"},
           {.what = "request", .result = "refused: \xE2\x80\xA8"}, {{"origin", "\xC2\x85\n\x1B"}});
  ASSERT_TRUE(log.close());
  const auto lines = lines_of(folder / "log");
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_TRUE(is_printable(lines[0])) << printable(lines[0]);
  EXPECT_EQ(nlohmann::json::parse(lines[0])["who"], "a?31m?");
}

TEST(AuditLog, KeepsNothingUnlessAsked) {
  AuditLog none;
  none.note(kNurse, {.what = "login", .result = "done"});
  none.second_passed();
  EXPECT_EQ(none.newest().line, 0U);
  EXPECT_EQ(none.lines_lost(), 0U);
  EXPECT_TRUE(none.close());
}

}  // namespace
}  // namespace fanlight::test
