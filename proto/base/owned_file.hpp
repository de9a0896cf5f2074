// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <filesystem>
#include <utility>

namespace fanlight {

/// A file descriptor that is closed with its owner.
class OwnedFile {
 public:
  OwnedFile() = default;
  /// As open(2), with mode 0600 for a new file. Where it fails is_open() is false, and errno says why.
  OwnedFile(const std::filesystem::path& path, int flags)
      : file_(open(path.c_str(), flags | O_CLOEXEC, 0600)) {}
  OwnedFile(OwnedFile&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  OwnedFile& operator=(OwnedFile&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~OwnedFile() {
    if (file_ >= 0) close(file_);
  }

  bool is_open() const { return file_ >= 0; }
  int get() const { return file_; }

 private:
  int file_ = -1;
};

}  // namespace fanlight
