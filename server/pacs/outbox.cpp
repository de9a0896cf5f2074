// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/outbox.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <random>
#include <system_error>

#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"
#include "server/pacs/private_file.hpp"

namespace fanlight {

namespace {

constexpr std::string_view kEnding = ".dcm";
constexpr std::size_t kMostInOneAssociation = 50;

Error unwritable(const std::filesystem::path& folder, std::string_view reason) {
  return {ErrorCode::kUnavailable,
          fmt::format(
              "{} cannot be written ({}), expected a folder with free space for what waits for the archive",
              printable(folder.string()), reason)};
}

/// Says nothing of the patient, and sorts by time.
std::string new_name() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  std::random_device random;
  return fmt::format("{:020}-{:08x}{}", std::chrono::duration_cast<std::chrono::nanoseconds>(now).count(),
                     random(), kEnding);
}

constexpr mode_t kEveryone = S_IRWXO;

bool is_regular(const std::filesystem::path& path) {
  struct stat found {};
  return lstat(path.c_str(), &found) == 0 && S_ISREG(found.st_mode);
}

/// Nobody else's link or pipe is followed, and no patient shown to everyone on this machine.
Result<void> make_private(const std::filesystem::path& folder) {
  std::error_code problem;
  const bool made = std::filesystem::create_directories(folder, problem);
  if (!problem && made) std::filesystem::permissions(folder, std::filesystem::perms::owner_all, problem);
  if (problem) return unwritable(folder, problem.message());
  struct stat found {};
  if (stat(folder.c_str(), &found) != 0 || access(folder.c_str(), R_OK | W_OK | X_OK) != 0)
    return unwritable(folder, std::generic_category().message(errno));
  if ((found.st_mode & kEveryone) == 0) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{} is open to every user of this machine, expected a folder that is not "
                           "(chmod 700), since it shows patients",
                           printable(folder.string()))};
}

/// A folder belongs to the first archive that it was used for.
Result<void> bind_to(const std::filesystem::path& folder, const DicomPeer& peer) {
  const std::filesystem::path path = folder / "archive";
  const int failure = write_private_file(path, ExistingFile::kKeep, shown(peer) + "\n");
  if (failure == 0) return {};
  if (failure != EEXIST) return unwritable(folder, std::generic_category().message(failure));
  std::string first;
  std::getline(std::ifstream(path), first);
  if (first == shown(peer)) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{} is the queue for {}, expected that archive or another folder; to send what "
                           "waits elsewhere, remove its file \"archive\"",
                           printable(folder.string()), printable(first))};
}

}  // namespace

Result<Outbox> Outbox::open(const std::filesystem::path& folder, const DicomPeer& peer) {
  if (auto made = make_private(folder); !made) return made.error();
  if (auto bound = bind_to(folder, peer); !bound) return bound.error();
  return Outbox(folder, peer);
}

Outbox::~Outbox() {
  if (lock_ >= 0) close(lock_);
}

Result<std::filesystem::path> Outbox::add_by(const std::function<int(int)>& write) {
  std::filesystem::path path = folder_ / new_name();
  const int failure = write_private_file(path, ExistingFile::kKeep, write);
  if (failure == 0) return path;
  return unwritable(folder_, std::generic_category().message(failure));
}

Result<std::filesystem::path> Outbox::add(std::span<const std::uint8_t> object) {
  const std::string_view bytes(reinterpret_cast<const char*>(object.data()), object.size());
  return add_by([bytes](int file) { return write_all(file, bytes); });
}

Result<std::filesystem::path> Outbox::add_file(const std::filesystem::path& path) {
  std::ifstream from(path, std::ios::binary);
  return add_by([&from](int file) {
    if (!from) return EIO;
    std::vector<char> part(std::size_t{1} << 20);
    while (from) {
      from.read(part.data(), static_cast<std::streamsize>(part.size()));
      if (const int failed = write_all(file, {part.data(), static_cast<std::size_t>(from.gcount())});
          failed != 0)
        return failed;
    }
    return from.eof() ? 0 : EIO;
  });
}

void Outbox::take_back(std::span<const std::filesystem::path> added) {
  for (const std::filesystem::path& path : added) {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
}

std::vector<std::filesystem::path> Outbox::names() const {
  std::vector<std::filesystem::path> found;
  std::error_code problem;
  for (std::filesystem::directory_iterator at(folder_, problem), end; !problem && at != end;
       at.increment(problem)) {
    const std::filesystem::path& path = at->path();
    const bool is_named_so = path.extension() == kEnding && !path.filename().string().starts_with('.');
    if (is_named_so && is_regular(path)) found.push_back(path);
  }
  std::ranges::sort(found);
  return found;
}

bool Outbox::has_untried() const {
  const auto all = names();
  return std::ranges::any_of(all, [this](const auto& path) { return !deferred_.contains(path); });
}

std::vector<std::filesystem::path> Outbox::next_files(const std::set<std::filesystem::path>& tried) const {
  std::vector<std::filesystem::path> files = names();
  std::erase_if(files, [&tried](const auto& path) { return tried.contains(path); });
  std::ranges::stable_partition(files, [this](const auto& path) { return !deferred_.contains(path); });
  files.resize(std::min(files.size(), kMostInOneAssociation));
  return files;
}

Result<bool> Outbox::become_sender() {
  if (lock_ >= 0) return true;
  // NFS locks files that are open for writing only.
  const int file = ::open((folder_ / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return unwritable(folder_, std::generic_category().message(errno));
  if (flock(file, LOCK_EX | LOCK_NB) == 0) {
    lock_ = file;
    return true;
  }
  const int failure = errno;
  close(file);
  if (failure == EWOULDBLOCK) return false;
  return Error{ErrorCode::kUnavailable,
               fmt::format("{} cannot be locked ({}), expected a file system with locks",
                           printable(folder_.string()), std::generic_category().message(failure))};
}

Result<void> Outbox::refuse(const std::filesystem::path& path) const {
  const std::filesystem::path refused = folder_ / "refused";
  std::error_code problem;
  std::filesystem::create_directory(refused, problem);
  if (!problem) std::filesystem::rename(path, refused / path.filename(), problem);
  if (problem && problem != std::errc::no_such_file_or_directory)
    return unwritable(refused, problem.message());
  return {};
}

bool Outbox::settle(const std::filesystem::path& path, const StoreOutcome& outcome, Report& report) {
  using State = StoreOutcome::State;
  std::string sentence =
      outcome.sentence.empty() ? "" : fmt::format("{}: {}", shown(peer_), outcome.sentence);
  bool is_done = false;
  if (outcome.state == State::kStored) {
    std::error_code problem;
    std::filesystem::remove(path, problem);
    if (problem) sentence = unwritable(folder_, problem.message()).message;
    ++report.stored;
    is_done = true;
  } else if (outcome.state == State::kRefused) {
    const auto moved = refuse(path);
    if (!moved) sentence = moved.error().message;
    is_done = static_cast<bool>(moved);
    if (is_done) ++report.refused;
  } else if (!std::filesystem::exists(path)) {
    return true;  // it was removed by hand
  }
  if (is_done) {
    deferred_.erase(path);
  } else {
    deferred_.insert(path);
  }
  if (!sentence.empty()) report.sentence = std::move(sentence);
  return is_done;
}

Result<Outbox::Report> Outbox::send(const std::atomic<bool>& stop) {
  Report report;
  std::set<std::filesystem::path> tried;
  int failures = 0;  // in a row
  while (!stop && failures < kMostFailures) {
    const std::vector<std::filesystem::path> files = next_files(tried);
    if (files.empty()) break;
    const auto outcomes = store_files(peer_, files, stop);
    if (!outcomes) {
      if (report.stored + report.refused == 0) return outcomes.error();
      report.sentence = outcomes.error().message;
      break;
    }
    report.reached = true;
    for (std::size_t at = 0; at < files.size(); ++at) {
      const StoreOutcome& outcome = (*outcomes)[at];
      if (outcome.state == StoreOutcome::State::kNotTried) continue;
      tried.insert(files[at]);
      failures = settle(files[at], outcome, report) ? 0 : failures + 1;
    }
  }
  return report;
}

}  // namespace fanlight
