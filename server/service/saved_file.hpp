// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>

#include "proto/base/result.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// A file that follows a state of the server. Written whole on a thread of the encoders, at most once at a
/// time. Server thread only.
class SavedFile {
 public:
  struct Content {
    std::string name;                                    ///< such as "the presets", for messages
    std::function<std::string()> text;                   ///< of the whole file
    mode_t mode = 0666;                                  ///< of a new file, less the process's umask
    std::function<void(const Result<void>&)> written{};  ///< may be empty; not called by finish()
  };
  /// What `content` refers to must outlive this object, and no work may run after its end.
  SavedFile(std::filesystem::path path, Content content, Executor executor);
  SavedFile(const SavedFile&) = delete;
  SavedFile& operator=(const SavedFile&) = delete;

  /// The state has changed: writes the file soon.
  void changed();

  /// Writes at once what is not written yet: the server ends.
  void finish();

  bool is_writing() const { return writing_; }

 private:
  void write();
  Result<void> save(const std::string& text) const;

  std::filesystem::path path_;
  Content content_;
  Executor executor_;
  bool writing_ = false;
  bool unwritten_ = false;  // the state has changed since the last writing began, or that has failed
};

/// Copies a file that could not be read, or not whole, before anything replaces it; where the copy is, empty
/// where it failed.
std::string copied_aside(const std::filesystem::path& path);

}  // namespace fanlight
