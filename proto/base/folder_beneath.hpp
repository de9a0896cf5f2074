// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace fanlight {

/// The folder of a file, opened from another folder above it without following a symbolic link on the way:
/// who may write into a folder cannot lead a write out of it. Keeps it open. Any thread.
class FolderBeneath {
 public:
  FolderBeneath() = default;
  FolderBeneath(const FolderBeneath&) = delete;
  FolderBeneath& operator=(const FolderBeneath&) = delete;
  ~FolderBeneath();

  enum class Missing { kFail, kMake };
  /// Opens the folder of `path`, whose name begins with that of `root`; what `root` itself is, is not looked
  /// at. Returns 0 or an errno: ELOOP where a link is on the way, EINVAL where `path` is not beneath `root`.
  int open(const std::filesystem::path& root, const std::filesystem::path& path, Missing missing);

  /// A name of `path` for other calls, which leads to the folder that was opened. Its last part may still be
  /// a link. Precondition: open() returned 0.
  std::filesystem::path name() const;

 private:
  int folder_ = -1;
  std::filesystem::path file_;
};

}  // namespace fanlight
