// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/igs_sequence.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstdio>
#include <new>
#include <utility>

#include "acquisition/replay/igs_header.hpp"
#include "acquisition/replay/image_orientation.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kChunkBytes = 262'144;

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

Result<std::unique_ptr<std::uint8_t[]>> allocate(const IgsFile& from, std::uint64_t bytes) {
  std::unique_ptr<std::uint8_t[]> memory(new (std::nothrow) std::uint8_t[bytes]);
  if (memory == nullptr) {
    return from.bad(fmt::format("its pixels need {} bytes", bytes), "as much free memory",
                    ErrorCode::kUnavailable);
  }
  return memory;
}

Result<void> read_plain(const IgsFile& from, std::span<std::uint8_t> pixels) {
  const std::uint64_t present = std::fread(pixels.data(), 1, pixels.size(), from.file);
  if (present == pixels.size()) return {};
  return from.bad(fmt::format("{} bytes of pixels can be read", present), fmt::format("{}", pixels.size()));
}

/// zlib's state, and the chunk of the file that it reads.
class Inflater {
 public:
  Inflater(std::FILE* file, std::uint64_t compressed_bytes)
      : file_(file), unread_(compressed_bytes), chunk_(kChunkBytes) {}
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  bool start() { return inflateInit(&stream_) == Z_OK; }

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

Result<void> read_compressed(const IgsFile& from, std::uint64_t compressed_bytes,
                             std::span<std::uint8_t> pixels) {
  Inflater inflater(from.file, compressed_bytes);
  if (!inflater.start()) return from.bad("zlib cannot start", "free memory", ErrorCode::kUnavailable);
  std::uint64_t written = 0;
  std::uint8_t beyond = 0;  // receives one byte behind the last pixel
  for (;;) {
    const auto room = pixels.subspan(written);
    written += inflater.inflate_some(room.empty() ? std::span(&beyond, 1) : room);
    if (written > pixels.size()) {
      return from.bad("its compressed pixels are more than its DimSize",
                      fmt::format("{} bytes", pixels.size()));
    }
    if (inflater.status() == Z_STREAM_END) break;
    if (inflater.status() != Z_OK) {
      return from.bad(fmt::format("its compressed pixels are damaged or cut off after {} bytes", written),
                      fmt::format("{} bytes", pixels.size()));
    }
  }
  if (written == pixels.size()) return {};
  return from.bad(fmt::format("its compressed pixels are {} bytes", written),
                  fmt::format("{}", pixels.size()));
}

/// Changes all frames from the file's axis order to Fanlight's.
Result<void> arrange_frames(const IgsFile& from, const ImageOrientation& orientation, IgsSequence& sequence) {
  if (orientation == ImageOrientation{}) return {};
  if (orientation.lines_in_rows) {
    std::swap(sequence.columns, sequence.rows);
    if (sequence.pixel_size) std::swap(sequence.pixel_size->width_mm, sequence.pixel_size->height_mm);
  }
  const std::uint64_t bytes = sequence.frame_bytes();
  const auto image = allocate(from, bytes);
  if (!image) return image.error();
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const std::span frame(sequence.pixels.get() + i * bytes, bytes);
    std::ranges::copy(frame, image->get());
    arrange_frame({image->get(), bytes}, orientation, {sequence.columns, sequence.rows}, frame);
  }
  return {};
}

Result<IgsSequence> read_sequence(const IgsFile& from, std::uint64_t max_bytes) {
  if (from.bytes == 0) return from.bad("the file is empty", "a MetaImage sequence");
  auto header = read_igs_header(from, max_bytes);
  if (!header) return header.error();
  IgsSequence& sequence = header->sequence;
  const std::uint64_t bytes = sequence.frame_bytes() * sequence.frames.size();
  auto pixels = allocate(from, bytes);
  if (!pixels) return pixels.error();
  sequence.pixels = *std::move(pixels);
  const std::span memory(sequence.pixels.get(), bytes);
  const std::uint64_t compressed_bytes = header->compressed_bytes.value_or(from.bytes - header->header_bytes);
  const auto read =
      sequence.compressed ? read_compressed(from, compressed_bytes, memory) : read_plain(from, memory);
  if (!read) return read.error();
  if (const auto done = arrange_frames(from, header->orientation, sequence); !done) return done.error();
  return std::move(sequence);
}

}  // namespace

Result<IgsSequence> read_igs_sequence(const std::filesystem::path& path, std::uint64_t max_bytes) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status)) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{}: there is no such file, expected an .igs.mha sequence", shown(path))};
  }
  // Opening a pipe would block until its other end is opened.
  if (!std::filesystem::is_regular_file(status)) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: this is no regular file, expected an .igs.mha sequence", shown(path))};
  }
  const std::uint64_t bytes = std::filesystem::file_size(path, failure);
  File file(failure ? nullptr : std::fopen(path.c_str(), "rbe"));
  if (file == nullptr) {
    return Error{
        ErrorCode::kUnavailable,
        fmt::format("{}: the file cannot be opened, expected one that this user may read", shown(path))};
  }
  return read_sequence({.name = shown(path), .file = file.get(), .bytes = bytes}, max_bytes);
}

}  // namespace fanlight
