// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <utility>

#include "proto/base/result.hpp"

namespace fanlight {

/// Lets one process at a time change a file that is read, edited and replaced. The lock is on the folder: a
/// lock on the file would stay with the file that was replaced. It ends with this object or the process.
class FolderLock {
 public:
  /// Locks the folder of the file. Waits up to 10 s for others. Errors, kUnavailable: there is no such
  /// folder, or another process keeps the lock. A file system without locks is not locked.
  static Result<FolderLock> take(const std::filesystem::path& file);

  FolderLock(FolderLock&& other) noexcept : folder_(std::exchange(other.folder_, -1)) {}
  FolderLock& operator=(FolderLock&& other) noexcept {
    std::swap(folder_, other.folder_);
    return *this;
  }
  ~FolderLock();

 private:
  explicit FolderLock(int folder) : folder_(folder) {}

  int folder_;
};

}  // namespace fanlight
