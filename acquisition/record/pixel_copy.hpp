// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <span>
#include <system_error>
#include <vector>

#include "acquisition/source/printable.hpp"
#include "proto/base/file_replacement.hpp"
#include "proto/base/owned_file.hpp"
#include "proto/base/result.hpp"
#include "proto/exchange/recording_link.hpp"

namespace fanlight {

/// The file with the pixels of a segment, read from front to back.
class PixelReader {
 public:
  explicit PixelReader(const std::filesystem::path& path) : path_(path), file_(path, O_RDONLY) {}

  Result<void> read(std::uint64_t offset, std::span<std::uint8_t> to) const {
    while (!to.empty()) {
      const ssize_t got = pread(file_.get(), to.data(), to.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        return Error{
            ErrorCode::kUnavailable,
            fmt::format("{} could not be read ({}), expected the pixels of a recording", shown(path_),
                        got == 0 ? "it is shorter" : std::generic_category().message(errno))};
      }
      offset += static_cast<std::uint64_t>(got);
      to = to.subspan(static_cast<std::size_t>(got));
    }
    return {};
  }

 private:
  const std::filesystem::path& path_;
  OwnedFile file_;
};

/// Where pixels go: as they are, or through zlib.
class PixelSink {
 public:
  PixelSink(int file, PixelForm form) : file_(file), form_(form), packed_(std::size_t{1} << 20) {}
  ~PixelSink() {
    if (started_) deflateEnd(&stream_);
  }
  PixelSink(const PixelSink&) = delete;  // zlib's state points into itself
  PixelSink& operator=(const PixelSink&) = delete;

  /// Returns 0 or an errno.
  int write(std::span<const std::uint8_t> pixels) {
    int failure = 0;
    if (form_ == PixelForm::kRaw) {
      written_ += pixels.size();
      failure = write_all(file_, {reinterpret_cast<const char*>(pixels.data()), pixels.size()});
    } else {
      failure = deflate_all(pixels, Z_NO_FLUSH);
    }
    begin_write_back();
    return failure;
  }
  int finish() { return form_ == PixelForm::kRaw ? 0 : deflate_all({}, Z_FINISH); }

  std::uint64_t written() const { return written_; }

 private:
  /// So that the sync at the end has little left to do, and can be ended soon.
  void begin_write_back() {
    constexpr std::uint64_t kEvery = 16 << 20;
    if (written_ - sent_back_ < kEvery) return;
    sync_file_range(file_, 0, 0, SYNC_FILE_RANGE_WRITE);
    sent_back_ = written_;
  }

  int deflate_all(std::span<const std::uint8_t> pixels, int flush) {
    // A third of the time of the usual level, for a twentieth more bytes: speckle packs badly.
    if (!started_ && deflateInit(&stream_, 1) != Z_OK) return ENOMEM;
    started_ = true;
    stream_.next_in = const_cast<Bytef*>(pixels.data());  // zlib only reads it
    stream_.avail_in = static_cast<uInt>(pixels.size());
    do {
      stream_.next_out = packed_.data();
      stream_.avail_out = static_cast<uInt>(packed_.size());
      deflate(&stream_, flush);
      const std::size_t bytes = packed_.size() - stream_.avail_out;
      written_ += bytes;
      if (const int failure = write_all(file_, {reinterpret_cast<const char*>(packed_.data()), bytes}))
        return failure;
    } while (stream_.avail_out == 0);
    return 0;
  }

  int file_;
  PixelForm form_;
  std::vector<std::uint8_t> packed_;
  z_stream stream_{};
  bool started_ = false;
  std::uint64_t written_ = 0;
  std::uint64_t sent_back_ = 0;
};

}  // namespace fanlight
