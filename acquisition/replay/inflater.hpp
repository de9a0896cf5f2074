// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <vector>

namespace fanlight {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
/// Best ratio of Deflate: one byte of input yields at most this many bytes of output.
inline constexpr std::uint64_t kMostInflation = 1032;

using File = std::unique_ptr<std::FILE, FileCloser>;

/// zlib's state, and the chunk of the file that it reads.
class Inflater {
 public:
  Inflater(std::FILE* file, std::uint64_t compressed_bytes)
      : file_(file), unread_(compressed_bytes), chunk_(262'144) {}
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;  // zlib's state points into itself
  Inflater& operator=(const Inflater&) = delete;

  /// `gzip`: the stream has a header of gzip, else of zlib.
  bool start(bool gzip) { return inflateInit2(&stream_, MAX_WBITS + (gzip ? 16 : 0)) == Z_OK; }

  /// Inflates to the front of `to` and reads the file as needed. Returns the number of bytes written;
  /// status() is then zlib's result. Z_BUF_ERROR: the input ended too early.
  std::uint64_t inflate_some(std::span<std::uint8_t> to) {
    if (stream_.avail_in == 0) {
      const std::size_t wanted = std::min<std::uint64_t>(unread_, chunk_.size());
      stream_.avail_in = static_cast<uInt>(std::fread(chunk_.data(), 1, wanted, file_));
      stream_.next_in = chunk_.data();
      unread_ -= stream_.avail_in;
    }
    const auto room = static_cast<uInt>(std::min<std::uint64_t>(to.size(), 1U << 30));
    stream_.next_out = to.data();
    stream_.avail_out = room;
    status_ = inflate(&stream_, Z_NO_FLUSH);
    return room - stream_.avail_out;
  }
  int status() const { return status_; }

 private:
  std::FILE* file_;
  std::uint64_t unread_;
  std::vector<std::uint8_t> chunk_;
  z_stream stream_{};
  int status_ = Z_OK;
};

}  // namespace fanlight
