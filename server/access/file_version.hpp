// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>

namespace fanlight {

/// Detects from stat() that a file changed, also when an older file replaced it, as `mv` and `cp -p` do.
struct FileVersion {
  dev_t device = 0;
  ino_t inode = 0;
  off_t bytes = 0;
  std::int64_t written_ns = 0;
  std::int64_t changed_ns = 0;  ///< also by a new name, owner or mode

  bool operator==(const FileVersion&) const = default;
};

/// All zero if there is no such file.
FileVersion file_version(const std::filesystem::path& path);

}  // namespace fanlight
