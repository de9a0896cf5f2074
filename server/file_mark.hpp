#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>

namespace fanlight {

/// Tells one version of a file from another without reading it; also where a file takes another's place that
/// was written before it was, as `mv` and `cp -p` do.
struct FileMark {
  dev_t device = 0;
  ino_t inode = 0;
  off_t bytes = 0;
  std::int64_t written_ns = 0;
  std::int64_t changed_ns = 0;  ///< its place, owner or mode too

  bool operator==(const FileMark&) const = default;
};

/// All zero where there is no such file.
FileMark file_mark(const std::filesystem::path& path);

}  // namespace fanlight
