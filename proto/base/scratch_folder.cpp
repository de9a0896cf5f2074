// SPDX-License-Identifier: Apache-2.0
#include "proto/base/scratch_folder.hpp"

#include <cstdlib>
#include <string>
#include <system_error>

namespace fanlight {

ScratchFolder::ScratchFolder(std::string_view name) {
  std::error_code missing;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(missing);
  if (missing) return;
  std::string made = (folder / name).string() + "-XXXXXX";
  if (mkdtemp(made.data()) != nullptr) path_ = made;
}

Result<void> ScratchFolder::check() const {
  if (!path_.empty()) return {};
  return Error{ErrorCode::kUnavailable,
               "no temporary folder could be made, expected TMPDIR to be a folder that can be written"};
}

void ScratchFolder::remove() const {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace fanlight
