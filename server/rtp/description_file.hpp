// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "server/codec/encoder_pool.hpp"

namespace fanlight {

/// The file with the description (SDP) of the RTP stream, for its owner alone, since it may hold a key.
/// Written on another thread, since a disk may be slow. Server thread only.
class DescriptionFile {
 public:
  /// `path` empty: no file is written.
  DescriptionFile(std::filesystem::path path, Executor executor)
      : path_(std::move(path)), executor_(std::move(executor)) {}

  /// Replaces the file soon; an older text that waits is not written. An error is logged.
  void write(const std::string& text);

  /// Removes the file: the stream has ended.
  void remove();

 private:
  /// Shared with the jobs that write.
  struct Newest {
    std::mutex writing;                      // of the writers' threads alone
    std::atomic<std::uint64_t> version = 0;  // a job with another has been superseded
  };

  std::filesystem::path path_;
  Executor executor_;
  std::shared_ptr<Newest> newest_ = std::make_shared<Newest>();
};

}  // namespace fanlight
