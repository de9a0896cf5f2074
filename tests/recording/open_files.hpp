// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <system_error>

namespace fanlight::test {

/// Descriptors of this process whose file has this name.
inline std::size_t open_of(const std::filesystem::path& path) {
  std::size_t open = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    if (std::filesystem::read_symlink(entry, gone) == path) ++open;
  }
  return open;
}

}  // namespace fanlight::test
