// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/outbox.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <random>
#include <system_error>

#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"
#include "server/pacs/store.hpp"

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

/// Writes a file whole or not at all, for its owner alone.
int write_new_file(const std::filesystem::path& path, auto&& write) {
  constexpr mode_t kOwnerOnly = 0600;
  ReplacementFile file;
  int failure = file.create_unnamed(path, kOwnerOnly);
  if (failure == 0) failure = write(file.descriptor());
  if (failure == 0) failure = file.sync();
  if (failure == 0) failure = file.rename_if_free(path);
  if (failure == 0) sync_folder_of(path);
  return failure;
}

bool is_dicom_file(const std::filesystem::path& path) {
  constexpr std::size_t kPreamble = 128;
  std::ifstream file(path, std::ios::binary);
  std::string head(kPreamble + 4, '\0');
  return file.read(head.data(), static_cast<std::streamsize>(head.size())) &&
         head.substr(kPreamble) == "DICM";
}

}  // namespace

Result<Outbox> Outbox::open(const std::filesystem::path& folder) {
  std::error_code problem;
  const bool made = std::filesystem::create_directories(folder, problem);
  if (!problem && made) std::filesystem::permissions(folder, std::filesystem::perms::owner_all, problem);
  if (problem) return unwritable(folder, problem.message());
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    return unwritable(folder, std::generic_category().message(errno));
  return Outbox(folder);
}

Outbox::~Outbox() {
  if (lock_ >= 0) close(lock_);
}

Result<void> Outbox::add(std::span<const std::uint8_t> object) {
  const std::string_view bytes(reinterpret_cast<const char*>(object.data()), object.size());
  const int failure = write_new_file(folder_ / new_name(), [&](int file) { return write_all(file, bytes); });
  if (failure == 0) return {};
  return unwritable(folder_, std::generic_category().message(failure));
}

Result<void> Outbox::add_file(const std::filesystem::path& path) {
  if (!is_dicom_file(path)) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{} is no DICOM file, expected one that begins as DICOM wants it",
                             printable(path.string()))};
  }
  std::ifstream from(path, std::ios::binary);
  const int failure = write_new_file(folder_ / new_name(), [&](int file) {
    std::vector<char> part(std::size_t{1} << 20);
    while (from) {
      from.read(part.data(), static_cast<std::streamsize>(part.size()));
      if (const int failed = write_all(file, {part.data(), static_cast<std::size_t>(from.gcount())});
          failed != 0)
        return failed;
    }
    return from.eof() ? 0 : EIO;
  });
  if (failure == 0) return {};
  return unwritable(folder_, std::generic_category().message(failure));
}

std::vector<std::filesystem::path> Outbox::names() const {
  std::vector<std::filesystem::path> found;
  std::error_code problem;
  for (std::filesystem::directory_iterator at(folder_, problem), end; !problem && at != end;
       at.increment(problem)) {
    const std::filesystem::path& path = at->path();
    if (path.extension() == kEnding && !path.filename().string().starts_with('.')) found.push_back(path);
  }
  std::ranges::sort(found);
  return found;
}

Result<bool> Outbox::become_sender() {
  if (lock_ >= 0) return true;
  const int folder = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return unwritable(folder_, std::generic_category().message(errno));
  if (flock(folder, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(folder);
    return false;
  }
  lock_ = folder;
  return true;
}

Result<void> Outbox::refuse(const std::filesystem::path& path) const {
  const std::filesystem::path refused = folder_ / "refused";
  std::error_code problem;
  std::filesystem::create_directory(refused, problem);
  if (!problem) std::filesystem::rename(path, refused / path.filename(), problem);
  if (problem) return unwritable(refused, problem.message());
  return {};
}

Result<Outbox::Report> Outbox::send(const DicomPeer& peer) {
  Report report;
  for (std::vector<std::filesystem::path> files = names(); !files.empty(); files = names()) {
    files.resize(std::min(files.size(), kMostInOneAssociation));
    const auto outcomes = store_files(peer, files);
    if (!outcomes) {
      if (report.stored + report.refused == 0) return outcomes.error();
      report.sentence = outcomes.error().message;
      return report;
    }
    bool all_done = true;
    for (std::size_t at = 0; at < files.size(); ++at) {
      const StoreOutcome& outcome = (*outcomes)[at];
      if (!outcome.sentence.empty() && (all_done || outcome.state == StoreOutcome::State::kRefused))
        report.sentence = fmt::format("{}: {}", shown(peer), outcome.sentence);
      if (outcome.state == StoreOutcome::State::kNotSent) {
        all_done = false;
        continue;
      }
      if (outcome.state == StoreOutcome::State::kRefused) {
        if (auto moved = refuse(files[at]); !moved) return moved.error();
        ++report.refused;
        continue;
      }
      std::error_code problem;
      std::filesystem::remove(files[at], problem);
      if (problem) return unwritable(folder_, problem.message());
      ++report.stored;
    }
    if (!all_done) return report;
  }
  return report;
}

}  // namespace fanlight
