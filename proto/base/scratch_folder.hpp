// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// A new folder of this process's own among the temporary files, removed with all that is in it at the end.
/// Any thread, one at a time.
class ScratchFolder {
 public:
  /// `name`: its name begins so.
  explicit ScratchFolder(std::string_view name);
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() { remove(); }

  /// Error, kUnavailable: it could not be made, and path() is empty.
  Result<void> check() const;
  void remove() const;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace fanlight
