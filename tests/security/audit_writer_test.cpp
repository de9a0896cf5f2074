// SPDX-License-Identifier: Apache-2.0
// The thread of the audit log: a disk or a pipe that takes nothing holds no one up, and what was lost is
// told.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>
#include <vector>

#include "server/access/audit_entry.hpp"
#include "server/access/audit_file.hpp"
#include "server/access/audit_log.hpp"
#include "server/access/audit_writer.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

using Urgency = AuditWriter::Urgency;

/// What the sinks of one test share with it.
struct Disk {
  std::mutex mutex;
  std::condition_variable changed;
  bool stalled = false;
  bool entered = false;  // a call waits for the disk
  int failure = 0;
  bool has_room = true;
  std::vector<std::string> lines;
  std::size_t synced_lines = 0;
  int syncs = 0;

  void set_stalled(bool value) {
    const std::scoped_lock lock(mutex);
    stalled = value;
    changed.notify_all();
  }
  void wait_for_a_call() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [this] { return entered; });
  }
};

class SinkOnDisk : public AuditSink {
 public:
  explicit SinkOnDisk(std::shared_ptr<Disk> disk) : disk_(std::move(disk)) {}
  int append(std::string_view fields) override {
    std::unique_lock lock(disk_->mutex);
    disk_->entered = true;
    disk_->changed.notify_all();
    disk_->changed.wait(lock, [this] { return !disk_->stalled; });
    if (disk_->failure != 0) return disk_->failure;
    disk_->lines.emplace_back(fields);
    ++position_.line;
    return 0;
  }
  void wait_for_room() override {}
  int sync() override {
    const std::scoped_lock lock(disk_->mutex);
    disk_->synced_lines = disk_->lines.size();
    ++disk_->syncs;
    disk_->changed.notify_all();
    return 0;
  }
  bool has_room() override {
    const std::scoped_lock lock(disk_->mutex);
    return disk_->has_room;
  }
  void reopen() override {}
  std::string take_notice() override { return {}; }
  const AuditPosition& position() const override { return position_; }

 private:
  std::shared_ptr<Disk> disk_;
  AuditPosition position_;
};

TEST(AuditWriter, DoesNotWaitForADiskThatStalls) {
  const auto disk = std::make_shared<Disk>();
  AuditWriter writer(std::make_unique<SinkOnDisk>(disk));
  disk->set_stalled(true);
  writer.push("first", Urgency::kNow);
  disk->wait_for_a_call();
  // If push() waited, this would never end.
  constexpr std::size_t kMore = 10'000;
  for (std::size_t line = 0; line < kMore; ++line) writer.push("x", Urgency::kNow);
  EXPECT_EQ(writer.lost(), kMore - AuditWriter::kMostLines);
  disk->set_stalled(false);
  ASSERT_TRUE(writer.wait_until_written(std::chrono::seconds(60)));
  ASSERT_EQ(disk->lines.size(), 1 + AuditWriter::kMostLines + 1);
  const auto gap = nlohmann::json::parse("{" + disk->lines.back() + "}");
  EXPECT_EQ(gap["result"], "lost");
  EXPECT_EQ(gap["details"]["count"], kMore - AuditWriter::kMostLines);
}

TEST(AuditWriter, IsBoundedInBytesToo) {
  const auto disk = std::make_shared<Disk>();
  AuditWriter writer(std::make_unique<SinkOnDisk>(disk));
  disk->set_stalled(true);
  writer.push("first", Urgency::kNow);
  disk->wait_for_a_call();
  for (int line = 0; line < 10; ++line) writer.push(std::string(1 << 20, 'x'), Urgency::kNow);
  EXPECT_EQ(writer.lost(), 6U);
  disk->set_stalled(false);
}

TEST(AuditWriter, LeavesADiskThatNeverAnswers) {
  const auto disk = std::make_shared<Disk>();
  {
    AuditWriter writer(std::make_unique<SinkOnDisk>(disk));
    disk->set_stalled(true);
    writer.push("first", Urgency::kNow);
    disk->wait_for_a_call();
    EXPECT_FALSE(writer.end(std::chrono::milliseconds(50)));
  }
  disk->set_stalled(false);  // so that the thread ends before the test
  std::unique_lock lock(disk->mutex);
  EXPECT_TRUE(disk->changed.wait_for(lock, std::chrono::seconds(60), [&] { return disk->syncs > 0; }));
}

TEST(AuditWriter, SyncsActsAtOnceAndTheRestWithinASecond) {
  const auto disk = std::make_shared<Disk>();
  AuditWriter writer(std::make_unique<SinkOnDisk>(disk));
  const auto wait_until_synced = [&](std::size_t lines) {
    std::unique_lock lock(disk->mutex);
    return disk->changed.wait_for(lock, std::chrono::seconds(60),
                                  [&] { return disk->synced_lines == lines; });
  };
  writer.push("a", Urgency::kWithinASecond);
  EXPECT_TRUE(wait_until_synced(1));
  const int before = disk->syncs;
  for (std::size_t act = 0; act < 5; ++act) {
    writer.push("act", Urgency::kNow);
    ASSERT_TRUE(writer.wait_until_written(std::chrono::seconds(60)));
    EXPECT_EQ(disk->synced_lines, 2 + act) << "when it is written, it is synced";
  }
  EXPECT_EQ(disk->syncs, before + 5);
  writer.push("b", Urgency::kWithinASecond);
  EXPECT_TRUE(wait_until_synced(7)) << "although nothing more comes";
}

TEST(AuditWriter, WritesWhatIsLeftAtTheEnd) {
  const auto disk = std::make_shared<Disk>();
  {
    AuditWriter writer(std::make_unique<SinkOnDisk>(disk));
    for (int line = 0; line < 1000; ++line) writer.push("x", Urgency::kWithinASecond);
    EXPECT_TRUE(writer.end(std::chrono::seconds(60)));
  }
  EXPECT_EQ(disk->lines.size(), 1000U);
  EXPECT_EQ(disk->synced_lines, 1000U);
}

TEST(AuditWriter, KeepsTheKindOfTheFailure) {
  const auto disk = std::make_shared<Disk>();
  disk->failure = ENOSPC;
  AuditWriter writer(std::make_unique<SinkOnDisk>(disk));
  for (int line = 0; line < 3; ++line) writer.push("x", Urgency::kNow);
  ASSERT_TRUE(writer.wait_until_written(std::chrono::seconds(60)));
  EXPECT_EQ(writer.lost(), 3U);
  {
    const std::scoped_lock lock(disk->mutex);
    disk->failure = 0;
  }
  writer.push("x", Urgency::kNow);
  ASSERT_TRUE(writer.wait_until_written(std::chrono::seconds(60)));
  ASSERT_EQ(disk->lines.size(), 2U);
  const auto gap = nlohmann::json::parse("{" + disk->lines[0] + "}");
  EXPECT_EQ(gap["details"]["count"], 3);
  EXPECT_NE(std::string(gap["details"]["because"]).find("space"), std::string::npos);
}

TEST(AuditWriter, SaysWhetherTheNextLinesWillBeWritten) {
  const auto disk = std::make_shared<Disk>();
  AuditWriter writer(std::make_unique<SinkOnDisk>(disk));
  const auto set = [&](int failure, bool has_room) {
    const std::scoped_lock lock(disk->mutex);
    disk->failure = failure;
    disk->has_room = has_room;
  };
  const auto written = [&] {
    writer.push("x", Urgency::kNow);
    return writer.wait_until_written(std::chrono::seconds(60));
  };
  const auto comes_to = [&](bool wanted) {
    for (int tries = 0; tries < 600 && writer.can_write() != wanted; ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return writer.can_write() == wanted;
  };
  EXPECT_TRUE(writer.can_write());
  set(ENOSPC, true);
  ASSERT_TRUE(written());
  EXPECT_TRUE(comes_to(false)) << "a line was lost";
  set(0, true);
  EXPECT_TRUE(comes_to(true)) << "the line about it was written, without another one";
  set(0, false);
  ASSERT_TRUE(written());
  EXPECT_TRUE(comes_to(false));
  EXPECT_EQ(writer.lost(), 1U);
  set(0, true);
  EXPECT_TRUE(comes_to(true));
}

TEST(AuditLog, RefusesActsOnlyWhereItIsRequired) {
  AuditLog none;
  EXPECT_FALSE(none.refuses_acts());
  none.require();
  EXPECT_TRUE(none.refuses_acts()) << "there is no log at all";
  const TemporaryFolder folder;
  auto log = AuditLog::open(folder / "audit").value();
  log.require();
  EXPECT_FALSE(log.refuses_acts());
}

TEST(AuditFile, KeepsRoomBehindItsEndWhileItIsOpen) {
  const TemporaryFolder folder;
  const auto blocks = [&] {
    struct stat status {};
    ::stat((folder / "audit").c_str(), &status);
    return static_cast<std::uint64_t>(status.st_blocks) * 512;
  };
  {
    auto file = AuditFile::open(folder / "audit", 0).value();
    ASSERT_EQ(file->append(audit_fields({.name = "a"}, {.what = "b", .result = "c"}, nullptr)), 0);
    EXPECT_TRUE(file->has_room());
    if (blocks() < AuditFile::kReserveBytes) GTEST_SKIP() << "this file system reserves nothing";
    EXPECT_LT(std::filesystem::file_size(folder / "audit"), 1000U);
  }
  EXPECT_LT(blocks(), 100'000U);
  EXPECT_TRUE(AuditFile::open(folder / "audit", 0)) << "the chain is whole";
}

TEST(AuditFile, DoesNotWaitForEverForTheReaderOfAPipe) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  const auto opened = AuditFile::open(folder / "pipe", 0);
  ASSERT_FALSE(opened);
  EXPECT_NE(opened.error().message.find("nothing reads the pipe"), std::string::npos);
}

/// A pipe with a name, whose other end the test holds.
class NamedPipe {
 public:
  explicit NamedPipe(const std::filesystem::path& path) {
    if (mkfifo(path.c_str(), 0600) != 0) std::abort();
    end_ = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  }
  NamedPipe(const NamedPipe&) = delete;
  NamedPipe& operator=(const NamedPipe&) = delete;
  ~NamedPipe() { close(end_); }

  void read_into(std::string& text) const {
    std::array<char, 65536> part{};
    for (ssize_t bytes = 0; (bytes = read(end_, part.data(), part.size())) > 0;)
      text.append(part.data(), static_cast<std::size_t>(bytes));
  }

 private:
  int end_;
};

TEST(AuditWriter, DoesNotWaitForAPipeThatIsFull) {
  const TemporaryFolder folder;
  const NamedPipe pipe(folder / "pipe");
  AuditWriter writer(AuditFile::open(folder / "pipe", 0).value());
  const std::string fields =
      audit_fields({.name = "theatre 3"}, {.what = "control", .result = std::string(1000, 'x')}, nullptr);
  constexpr std::uint64_t kLines = 20'000;
  for (std::uint64_t line = 0; line < kLines; ++line) writer.push(fields, Urgency::kNow);
  EXPECT_GT(writer.lost(), 0U);
  // Once someone reads, the lines that waited come, and a line about those that did not fit.
  std::string text;
  while (!writer.wait_until_written(std::chrono::milliseconds(1))) pipe.read_into(text);
  pipe.read_into(text);
  AuditChain chain(AuditChain::Begin::kOfFile);
  std::istringstream lines(text);
  std::uint64_t gaps = 0;
  for (std::string line; std::getline(lines, line);) {
    ASSERT_TRUE(chain.take(line)) << chain.position().line;
    if (nlohmann::json::parse(line)["result"] == kAuditLost) ++gaps;
  }
  EXPECT_GT(gaps, 0U);
  EXPECT_EQ(chain.lost(), writer.lost());
  EXPECT_EQ(chain.lines() - gaps + chain.lost(), kLines) << "each line is there or counted";
}

TEST(AuditWriter, EndsWithAPipeThatIsFull) {
  const TemporaryFolder folder;
  const NamedPipe pipe(folder / "pipe");
  AuditWriter writer(AuditFile::open(folder / "pipe", 0).value());
  for (int line = 0; line < 3000; ++line) writer.push(std::string(1000, 'x'), Urgency::kNow);
  EXPECT_TRUE(writer.end(std::chrono::seconds(60)));
  EXPECT_GT(writer.lost(), 0U);
}

TEST(AuditWriter, LosesThePipeWithoutEndingTheProcess) {
  const TemporaryFolder folder;
  auto pipe = std::make_unique<NamedPipe>(folder / "pipe");
  AuditWriter writer(AuditFile::open(folder / "pipe", 0).value());
  const auto handler = std::signal(SIGPIPE, SIG_IGN);
  pipe.reset();
  writer.push("x", Urgency::kNow);
  ASSERT_TRUE(writer.wait_until_written(std::chrono::seconds(60)));
  EXPECT_EQ(writer.lost(), 1U);
  ASSERT_TRUE(writer.end(std::chrono::seconds(60)));
  std::signal(SIGPIPE, handler);
}

}  // namespace
}  // namespace fanlight::test
