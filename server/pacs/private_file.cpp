// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/private_file.hpp"

#include "proto/base/file_replacement.hpp"

namespace fanlight {

int write_private_file(const std::filesystem::path& path, ExistingFile existing,
                       const std::function<int(int)>& write) {
  constexpr mode_t kOwnerOnly = 0600;
  ReplacementFile file;
  const bool replaces = existing == ExistingFile::kReplace;
  // A file without a name cannot take one that exists.
  int failure = replaces ? file.create(path, kOwnerOnly) : file.create_unnamed(path, kOwnerOnly);
  if (failure == 0) failure = write(file.descriptor());
  if (failure == 0) failure = file.sync();
  if (failure == 0) failure = replaces ? file.replace(path) : file.rename_if_free(path);
  if (failure == 0) sync_folder_of(path);
  return failure;
}

int write_private_file(const std::filesystem::path& path, ExistingFile existing, std::string_view text) {
  return write_private_file(path, existing, [text](int file) { return write_all(file, text); });
}

}  // namespace fanlight
