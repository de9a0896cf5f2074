// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/stat.h>
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// Owner and mode of a replaced file.
struct FileAccess {
  mode_t mode = 0666;            ///< of a file that did not exist, less the process's umask
  bool must_keep_owner = false;  ///< fail if the owner of the old file cannot be kept; else only try
  /// A folder above the file, from which on no symbolic link is followed; empty: links are followed.
  std::filesystem::path beneath{};
};

/// A new file in the folder of another, which takes that one's name when it is whole. The destructor removes
/// it unless it did. Any thread.
class ReplacementFile {
 public:
  ReplacementFile() = default;
  ReplacementFile(const ReplacementFile&) = delete;
  ReplacementFile& operator=(const ReplacementFile&) = delete;
  ~ReplacementFile();

  // These return 0 or an errno.

  /// Makes the file, for writing. `mode`: less the process's umask.
  int create(const std::filesystem::path& target, mode_t mode);
  /// The same without a name where the file system can: a kill then leaves nothing behind.
  int create_unnamed(const std::filesystem::path& target, mode_t mode);
  /// Gives it the mode of the old file, and its owner as far as this process may.
  int copy_owner_of(const struct stat& old, bool must_keep_owner) const;
  int sync() const;
  /// Gives it a further name, and takes that from another file; no name where the file system has no hard
  /// links.
  void add_name(const std::filesystem::path& path) const;
  /// Closes it, and moves it to the name of `target`, in place of what is there.
  int replace(const std::filesystem::path& target);
  /// The same, but EEXIST where there is something of that name.
  int rename_if_free(const std::filesystem::path& target);

  int descriptor() const { return file_; }

 private:
  int create_named(const std::filesystem::path& target);

  int file_ = -1;
  std::filesystem::path name_;
};

/// Writes the file whole or not at all: the bytes go to a new file in the same folder, which is synced to the
/// disk and then takes the name. A reader of the name, also after a power cut, finds the old bytes or the
/// new ones. The mode of an old file is kept, and a symbolic link keeps pointing to it. A device or a pipe is
/// written as it stands, except with FileAccess::beneath. Blocks for as long as the disk takes; any thread.
/// Errors, kUnavailable: the reason; the old file is unchanged, and no other file is left.
Result<void> replace_file(const std::filesystem::path& path, std::string_view bytes,
                          const FileAccess& access = {});

/// The text of an errno of a write, for an error message.
std::string write_failure(int failure);

/// Writes all bytes to a descriptor, in several parts where needed. Returns 0, or the errno of the failure;
/// some of the bytes may then be written.
int write_all(int file, std::string_view bytes);

/// Syncs the folder of a file, so that a new name in it outlasts a power cut. A file system that cannot sync
/// a folder is left alone.
void sync_folder_of(const std::filesystem::path& path);

}  // namespace fanlight
