// SPDX-License-Identifier: Apache-2.0
#include "proto/base/file_replacement.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

#include "proto/base/folder_beneath.hpp"

namespace fanlight {

namespace {

std::filesystem::path folder_of(const std::filesystem::path& path) {
  return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

/// The file that the path names, behind symbolic links; the path itself if there is none.
std::filesystem::path target_of(const std::filesystem::path& path) {
  std::error_code absent;
  auto target = std::filesystem::canonical(path, absent);
  return absent ? path : target;
}

int write_in_place(const std::filesystem::path& path, std::string_view bytes) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (file < 0) return errno;
  const int failure = write_all(file, bytes);
  if (::close(file) != 0 && failure == 0) return errno;
  return failure;
}

int replace(const std::filesystem::path& path, std::string_view bytes, const FileAccess& access) {
  const bool follows = access.beneath.empty();
  FolderBeneath folder;
  if (!follows) {
    if (const int failure = folder.open(access.beneath, path, FolderBeneath::Missing::kFail)) return failure;
  }
  const std::filesystem::path target = follows ? target_of(path) : folder.name();
  struct stat old {};
  const bool exists = (follows ? ::stat(target.c_str(), &old) : ::lstat(target.c_str(), &old)) == 0;
  if (exists && !S_ISREG(old.st_mode)) {
    if (!follows) return S_ISLNK(old.st_mode) ? ELOOP : EEXIST;
    return write_in_place(target, bytes);
  }
  // A new name in the folder would replace a file that the process may not write.
  if (exists && ::faccessat(AT_FDCWD, target.c_str(), W_OK, AT_EACCESS) != 0) return errno;
  ReplacementFile next;
  if (const int failure = next.create(target, access.mode)) return failure;
  if (exists) {
    if (const int failure = next.copy_owner_of(old, access.must_keep_owner)) return failure;
  }
  if (const int failure = write_all(next.descriptor(), bytes)) return failure;
  if (const int failure = next.sync()) return failure;
  if (const int failure = next.replace(target)) return failure;
  sync_folder_of(target);
  return 0;
}

constexpr int kMostTries = 1000;  // an ended process with our number may have left files

std::filesystem::path own_name(const std::filesystem::path& target) {
  static std::atomic<unsigned> made = 0;
  return folder_of(target) / fmt::format(".fanlight-{}-{}", ::getpid(), made.fetch_add(1));
}

}  // namespace

ReplacementFile::~ReplacementFile() {
  if (file_ >= 0) ::close(file_);
  if (!name_.empty()) ::unlink(name_.c_str());
}

int ReplacementFile::create(const std::filesystem::path& target, mode_t mode) {
  for (int tries = 0; tries < kMostTries; ++tries) {
    const std::filesystem::path name = own_name(target);
    file_ = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (file_ >= 0) name_ = name;
    if (file_ >= 0 || errno != EEXIST) break;
  }
  return file_ >= 0 ? 0 : errno;
}

/// Links the unnamed file to a name of our own.
int ReplacementFile::create_named(const std::filesystem::path& target) {
  const std::string itself = fmt::format("/proc/self/fd/{}", file_);
  for (int tries = 0; tries < kMostTries; ++tries) {
    const std::filesystem::path name = own_name(target);
    if (::linkat(AT_FDCWD, itself.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) {
      name_ = name;
      return 0;
    }
    if (errno != EEXIST) return errno;
  }
  return EEXIST;
}

int ReplacementFile::create_unnamed(const std::filesystem::path& target, mode_t mode) {
  file_ = ::open(folder_of(target).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, mode);
  return file_ >= 0 ? 0 : create(target, mode);
}

int ReplacementFile::copy_owner_of(const struct stat& old, bool must_keep_owner) const {
  if (::fchown(file_, old.st_uid, old.st_gid) != 0 && must_keep_owner) return errno;
  return ::fchmod(file_, old.st_mode & 07777) == 0 ? 0 : errno;
}

int ReplacementFile::sync() const {
  return ::fsync(file_) == 0 ? 0 : errno;
}

void ReplacementFile::add_name(const std::filesystem::path& path) const {
  ::unlink(path.c_str());
  const std::string itself = name_.empty() ? fmt::format("/proc/self/fd/{}", file_) : name_.string();
  [[maybe_unused]] const int failure =
      ::linkat(AT_FDCWD, itself.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW);
}

int ReplacementFile::replace(const std::filesystem::path& target) {
  if (name_.empty()) {
    if (const int failure = create_named(target)) return failure;
  }
  if (::close(std::exchange(file_, -1)) != 0) return errno;
  if (::rename(name_.c_str(), target.c_str()) != 0) return errno;
  name_.clear();
  return 0;
}

int ReplacementFile::rename_if_free(const std::filesystem::path& target) {
  if (name_.empty()) {
    const std::string itself = fmt::format("/proc/self/fd/{}", file_);
    if (::linkat(AT_FDCWD, itself.c_str(), AT_FDCWD, target.c_str(), AT_SYMLINK_FOLLOW) != 0) return errno;
    return ::close(std::exchange(file_, -1)) == 0 ? 0 : errno;
  }
  if (::close(std::exchange(file_, -1)) != 0) return errno;
  if (::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, target.c_str(), RENAME_NOREPLACE) != 0) {
    if (errno != EINVAL && errno != ENOSYS) return errno;
    // A file system without that: a second name fails where there is one.
    if (::link(name_.c_str(), target.c_str()) != 0) return errno;
    return 0;  // the destructor removes the first name
  }
  name_.clear();
  return 0;
}

int write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return ENOSPC;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

void sync_folder_of(const std::filesystem::path& path) {
  const int folder = ::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  ::fsync(folder);
  ::close(folder);
}

std::string write_failure(int failure) {
  return failure == ELOOP ? "a symbolic link is on the way" : std::generic_category().message(failure);
}

Result<void> replace_file(const std::filesystem::path& path, std::string_view bytes,
                          const FileAccess& access) {
  const int failure = replace(path, bytes, access);
  if (failure == 0) return {};
  return Error{ErrorCode::kUnavailable,
               fmt::format("{} could not be written ({}), expected an existing, writable "
                           "folder with room for {} bytes",
                           path.string(), write_failure(failure), bytes.size())};
}

}  // namespace fanlight
