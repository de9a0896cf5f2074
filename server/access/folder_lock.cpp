// SPDX-License-Identifier: Apache-2.0
#include "server/access/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>
#include <thread>

namespace fanlight {

Result<FolderLock> FolderLock::take(const std::filesystem::path& file) {
  constexpr auto kBetweenTries = std::chrono::milliseconds(20);
  constexpr int kMostTries = 500;
  std::error_code absent;
  // A symbolic link may point into another folder, where the file is replaced.
  const auto target = std::filesystem::canonical(file, absent);
  const auto folder = (absent ? file : target).parent_path();
  const std::string name = folder.empty() ? "." : folder.string();
  FolderLock lock(::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock.folder_ < 0) {
    return Error{ErrorCode::kUnavailable, fmt::format("{}: the folder could not be opened ({}), expected one "
                                                      "that exists and is readable",
                                                      name, std::generic_category().message(errno))};
  }
  for (int tries = 0; ::flock(lock.folder_, LOCK_EX | LOCK_NB) != 0; ++tries) {
    if (errno != EWOULDBLOCK && errno != EINTR) return lock;
    if (tries >= kMostTries) {
      return Error{
          ErrorCode::kUnavailable,
          fmt::format("{}: another process has locked this folder for 10 s, expected it to end", name)};
    }
    std::this_thread::sleep_for(kBetweenTries);
  }
  return lock;
}

FolderLock::~FolderLock() {
  if (folder_ >= 0) ::close(folder_);
}

}  // namespace fanlight
