// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "proto/base/file_replacement.hpp"
#include "proto/base/result.hpp"
#include "server/access/file_version.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// A file that follows a state of the server. Written whole on a thread of the encoders, at most once at a
/// time. Server thread only.
class SavedFile {
 public:
  /// Makes the text of the whole file from a copy of the state; runs on any thread.
  using MakeText = std::function<std::string()>;
  struct Content {
    std::string name;                    ///< such as "the presets", for messages
    std::function<MakeText()> snapshot;  ///< copies the state
    FileAccess access{};
    /// A file that another program has changed since this object was made, or has written it, is left alone.
    bool respects_others = false;
    /// Called after each writing but that of finish(); may be empty. Errors: kBadInput, another program has
    /// changed the file; kUnavailable, the disk.
    std::function<void(const Result<void>&)> written{};
  };
  /// What `content` refers to must outlive this object, and no work may run after its end.
  SavedFile(std::filesystem::path path, Content content, Executor executor);
  SavedFile(const SavedFile&) = delete;
  SavedFile& operator=(const SavedFile&) = delete;

  /// The state has changed: writes the file soon, as the state is now.
  void changed();

  /// Writes at once what is not written yet: the server ends.
  void finish();

  /// Whether a writing is under way, or is to be tried again.
  bool is_busy() const { return writing_ || unwritten_; }

 private:
  /// Shared with a writing under way, which finish() may overtake.
  struct OnDisk {
    std::mutex mutex;
    std::uint64_t newest = 0;  // number of the newest text that was to be written
    FileVersion version;       // as this object has found or left the file
  };
  static Result<void> save(const std::filesystem::path& path, const Content& content, const std::string& text,
                           std::uint64_t number, OnDisk& on_disk);
  void write();

  std::filesystem::path path_;
  Content content_;
  Executor executor_;
  std::shared_ptr<OnDisk> on_disk_ = std::make_shared<OnDisk>();
  MakeText unwritten_;        // empty: all is written, or being written
  std::uint64_t number_ = 0;  // of the newest text
  bool writing_ = false;
};

}  // namespace fanlight
