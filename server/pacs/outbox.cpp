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
#include <tuple>
#include <utility>

#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"
#include "server/pacs/private_file.hpp"

namespace fanlight {

namespace {

constexpr std::string_view kEnding = ".dcm";
constexpr std::string_view kTried = "tried-";
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

/// The archive that a folder is for; empty: it was not used yet.
Result<std::string> bound_to(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "archive";
  std::ifstream file(path);
  const int failure = errno;
  if (!file) {
    if (failure == ENOENT) return std::string();
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} cannot be read ({}), expected the name of an archive",
                             printable(path.string()), std::generic_category().message(failure))};
  }
  std::string name;
  std::getline(file, name);
  return name;
}

Result<void> check_bound(const std::filesystem::path& folder, const std::string& archive) {
  const auto first = bound_to(folder);
  if (!first) return first.error();
  if (*first == archive) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("{} is the queue for \"{}\", expected that archive or another folder; to send what "
                  "waits elsewhere, end its sender and remove its file \"archive\"",
                  printable(folder.string()), printable(*first))};
}

/// A folder belongs to the first archive that it was used for.
Result<void> bind_to(const std::filesystem::path& folder, const std::string& archive) {
  const auto first = bound_to(folder);
  if (!first) return first.error();
  if (first->empty()) {
    const int failure = write_private_file(folder / "archive", ExistingFile::kKeep, archive + "\n");
    if (failure != 0 && failure != EEXIST)
      return unwritable(folder, std::generic_category().message(failure));
  }
  return check_bound(folder, archive);
}

bool is_waiting(const std::filesystem::path& path) {
  return path.extension() == kEnding && !path.filename().string().starts_with('.') && is_regular(path);
}

/// Whether the name says so.
bool was_tried(const std::filesystem::path& path) {
  return path.filename().string().starts_with(kTried);
}

/// When the file was tried last, or came.
std::filesystem::file_time_type time_of(const std::filesystem::path& path) {
  std::error_code gone;
  return std::filesystem::last_write_time(path, gone);
}

}  // namespace

Result<Outbox> Outbox::open(const std::filesystem::path& folder, Archive archive) {
  if (auto made = make_private(folder); !made) return made.error();
  if (auto bound = bind_to(folder, archive.name); !bound) return bound.error();
  return Outbox(folder, std::move(archive));
}

Result<Outbox> Outbox::open_to_add(const std::filesystem::path& folder) {
  if (auto made = make_private(folder); !made) return made.error();
  return Outbox(folder, Archive());
}

Outbox::~Outbox() {
  if (lock_ >= 0) close(lock_);
}

Result<std::filesystem::path> Outbox::stage_by(std::string label, const std::function<int(int)>& write) {
  const std::string name = new_name();
  if (!label.empty()) labels_[name] = std::move(label);
  std::filesystem::path path = folder_ / ("." + name);
  const int failure = write_private_file(path, ExistingFile::kKeep, write);
  if (failure == 0) return path;
  return unwritable(folder_, std::generic_category().message(failure));
}

Result<std::filesystem::path> Outbox::stage(std::span<const std::uint8_t> object, std::string label) {
  const std::string_view bytes(reinterpret_cast<const char*>(object.data()), object.size());
  return stage_by(std::move(label), [bytes](int file) { return write_all(file, bytes); });
}

Result<std::filesystem::path> Outbox::stage_file(const std::filesystem::path& path) {
  std::ifstream from(path, std::ios::binary);
  bool is_read = from.is_open();
  auto staged = stage_by(path.string(), [&from, &is_read](int file) {
    std::vector<char> part(std::size_t{1} << 20);
    while (from) {
      from.read(part.data(), static_cast<std::streamsize>(part.size()));
      if (const int failed = write_all(file, {part.data(), static_cast<std::size_t>(from.gcount())});
          failed != 0)
        return failed;
    }
    is_read = is_read && from.eof();
    return is_read ? 0 : EIO;
  });
  if (is_read) return staged;
  return Error{ErrorCode::kUnavailable,
               fmt::format("{} cannot be read to its end, expected a file that this user may read",
                           printable(path.string()))};
}

Result<void> Outbox::publish(std::span<const std::filesystem::path> staged) {
  for (const std::filesystem::path& path : staged) {
    std::error_code problem;
    std::filesystem::rename(path, folder_ / path.filename().string().substr(1), problem);
    if (problem) return unwritable(folder_, problem.message());
  }
  if (!staged.empty()) sync_folder_of(staged.front());
  return {};
}

void Outbox::discard(std::span<const std::filesystem::path> staged) {
  for (const std::filesystem::path& path : staged) {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
}

/// What was never tried first, each in the order of times, and of names where these are the same.
Result<Outbox::Paths> Outbox::waiting_files() const {
  std::vector<std::tuple<bool, std::filesystem::file_time_type, std::filesystem::path>> found;
  std::error_code problem;
  for (std::filesystem::directory_iterator at(folder_, problem), end; !problem && at != end;
       at.increment(problem)) {
    if (is_waiting(at->path()) && !stored_.contains(at->path()))
      found.emplace_back(was_tried(at->path()), time_of(at->path()), at->path());
  }
  if (problem) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} cannot be listed ({}), expected a folder that this user may read",
                             printable(folder_.string()), problem.message())};
  }
  std::ranges::sort(found);
  Paths paths;
  for (auto& [tried, time, path] : found) paths.push_back(std::move(path));
  return paths;
}

std::uint64_t Outbox::waiting() const {
  const auto files = waiting_files();
  return files ? files->size() : 0;
}

bool Outbox::can_be_written() const {
  return access(folder_.c_str(), R_OK | W_OK | X_OK) == 0;
}

std::uint64_t Outbox::refused() const {
  std::uint64_t files = 0;
  std::error_code problem;
  for (std::filesystem::directory_iterator at(folder_ / "refused", problem), end; !problem && at != end;
       at.increment(problem))
    files += is_waiting(at->path()) ? 1 : 0;
  return files;
}

bool Outbox::has_untried() const {
  const auto files = waiting_files();
  return files && std::ranges::any_of(*files, [this](const auto& path) { return !deferred_.contains(path); });
}

Result<Outbox::Paths> Outbox::next_files(Which which, const std::set<std::filesystem::path>& tried) const {
  auto files = waiting_files();
  if (!files) return files;
  std::erase_if(*files, [&](const auto& path) {
    return tried.contains(path) || (which == Which::kUntried && deferred_.contains(path));
  });
  files->resize(std::min(files->size(), kMostInOneAssociation));
  return files;
}

Result<bool> Outbox::become_sender() {
  if (lock_ >= 0) return true;
  // NFS locks files that are open for writing only.
  const int file = ::open((folder_ / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (file < 0) return unwritable(folder_, std::generic_category().message(errno));
  if (flock(file, LOCK_EX | LOCK_NB) == 0) {
    lock_ = file;
    remove_stale();
    return true;
  }
  const int failure = errno;
  close(file);
  if (failure == EWOULDBLOCK) return false;
  return Error{ErrorCode::kUnavailable,
               fmt::format("{} cannot be locked ({}), expected a file system with locks",
                           printable(folder_.string()), std::generic_category().message(failure))};
}

/// Removes what a program has staged that was killed before it was done. None takes a day.
void Outbox::remove_stale() const {
  constexpr auto kDay = std::chrono::hours(24);
  std::error_code problem;
  for (std::filesystem::directory_iterator at(folder_, problem), end; !problem && at != end;
       at.increment(problem)) {
    const std::string name = at->path().filename().string();
    const bool is_staged = name.starts_with('.') && name.ends_with(kEnding) && is_regular(at->path());
    if (!is_staged || time_of(at->path()) > std::filesystem::file_time_type::clock::now() - kDay) continue;
    std::error_code ignored;
    std::filesystem::remove(at->path(), ignored);
  }
}

/// Nothing in the folder is replaced, and no link followed.
Result<void> Outbox::refuse(const std::filesystem::path& path) const {
  const std::filesystem::path refused = folder_ / "refused";
  if (mkdir(refused.c_str(), S_IRWXU) != 0 && errno != EEXIST)
    return unwritable(refused, std::generic_category().message(errno));
  struct stat found {};
  if (lstat(refused.c_str(), &found) != 0 || !S_ISDIR(found.st_mode))
    return unwritable(refused, "it is no folder");
  std::filesystem::path target = refused / path.filename();
  if (lstat(target.c_str(), &found) == 0) target = refused / new_name();
  std::error_code problem;
  std::filesystem::rename(path, target, problem);
  if (problem) return unwritable(refused, problem.message());
  return {};
}

/// A stored object whose file stays must not be sent again, nor count as one that waits.
void Outbox::remove_stored(const std::filesystem::path& path, std::string& sentence) {
  std::error_code problem;
  std::filesystem::remove(path, problem);
  if (problem) {
    stored_.insert(path);
    sentence = fmt::format("{} is stored, and cannot be removed ({}): expected a folder that can be written",
                           printable(path.string()), problem.message());
  }
}

/// What has failed comes after all others, also for the next program.
std::filesystem::path Outbox::defer(const std::filesystem::path& path) {
  std::filesystem::path target = path;
  if (!was_tried(path)) target.replace_filename(std::string(kTried) + path.filename().string());
  std::error_code problem;
  std::filesystem::rename(path, target, problem);
  if (problem) target = path;
  std::filesystem::last_write_time(target, std::filesystem::file_time_type::clock::now(), problem);
  deferred_.insert(target);
  return target;
}

/// What a file was called when it was given to this program; else its own name.
std::string Outbox::label_of(const std::filesystem::path& path) const {
  std::string name = path.filename().string();
  if (was_tried(path)) name.erase(0, kTried.size());
  const auto found = labels_.find(name);
  return printable(found == labels_.end() ? path.filename().string() : found->second);
}

/// Counts an outcome, and does to the file what follows from it; returns its name from now on.
std::filesystem::path Outbox::settle(const std::filesystem::path& path, const StoreOutcome& outcome,
                                     Report& report) {
  using State = StoreOutcome::State;
  std::error_code unknown;
  if (outcome.state != State::kStored && !std::filesystem::exists(path, unknown) && !unknown) return path;
  std::string sentence = outcome.sentence.empty()
                             ? ""
                             : fmt::format("{}: {}: {}", archive_.name, label_of(path), outcome.sentence);
  bool is_done = outcome.state != State::kNotSent;
  if (outcome.state == State::kStored) {
    remove_stored(path, sentence);
    ++report.stored;
  } else if (outcome.state == State::kRefused) {
    const auto moved = refuse(path);
    is_done = static_cast<bool>(moved);
    if (moved) ++report.refused;
    if (!moved) sentence = moved.error().message;
  }
  deferred_.erase(path);
  if (!sentence.empty()) report.sentence = std::move(sentence);
  return is_done ? path : defer(path);
}

Result<Outbox::Report> Outbox::send(Which which, const std::atomic<bool>& stop) {
  if (auto bound = check_bound(folder_, archive_.name); !bound) return bound.error();
  Report report;
  std::set<std::filesystem::path> tried;
  int failures = 0;  // in a row
  while (!stop && failures < kMostFailuresInARow) {
    const auto files = next_files(which, tried);
    if (!files) return files.error();
    if (files->empty()) break;
    const auto outcomes = archive_.store(*files, stop);
    if (!outcomes) {
      if (report.stored + report.refused == 0) return outcomes.error();
      report.sentence = outcomes.error().message;
      break;
    }
    for (std::size_t at = 0; at < files->size(); ++at) {
      const StoreOutcome& outcome = (*outcomes)[at];
      if (outcome.state == StoreOutcome::State::kNotTried) continue;
      tried.insert(settle((*files)[at], outcome, report));
      if (outcome.is_local) continue;
      report.reached = true;
      failures = outcome.state == StoreOutcome::State::kNotSent ? failures + 1 : 0;
    }
  }
  return report;
}

}  // namespace fanlight
