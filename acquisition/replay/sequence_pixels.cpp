// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <utility>
#include <vector>

#include "acquisition/replay/pixel_reading.hpp"
#include "acquisition/replay/sequence_pixels.hpp"

namespace fanlight {

/// In an image neighbours below each other are alike. Where pixels that are `rows` apart in the file are much
/// more alike than those that are `columns` apart, the two were exchanged.
void SequencePixels::Reading::judge_layout(std::span<const std::uint8_t> frame) {
  const std::uint64_t line = orientation.lines_in_rows ? rows : columns;
  const std::uint64_t other = orientation.lines_in_rows ? columns : rows;
  if (line == other) return;
  const auto difference = [frame](std::uint64_t apart) {
    std::uint64_t sum = 0;
    for (std::size_t i = apart; i < frame.size(); ++i)
      sum += static_cast<std::uint64_t>(std::abs(int{frame[i]} - int{frame[i - apart]}));
    return static_cast<double>(sum) / static_cast<double>(frame.size() - apart);
  };
  constexpr double kMuchMoreAlike = 0.6;
  transposed = difference(other) < kMuchMoreAlike * difference(line);
}

/// Afterwards `next` is at most `frame`: compressed frames in between are read over.
Result<void> SequencePixels::Reading::go_to(std::uint64_t frame) {
  if (frame == next || (inflater && frame > next)) return {};
  if (reader) {
    next = frame;
    return {};
  }
  next = inflater ? 0 : frame;
  if (std::fseek(from.file, first_pixel + static_cast<long>(next * frame_bytes()), SEEK_SET) != 0)
    return from.bad("the file cannot be read from another place", "a file that can");
  if (!inflater) return {};
  inflater.emplace(from.file, compressed_bytes);
  if (inflater->start(gzip)) return {};
  return from.bad("zlib cannot start", "free memory", ErrorCode::kUnavailable);
}

Result<void> SequencePixels::Reading::read_plain(std::span<std::uint8_t> to) {
  const std::uint64_t present = std::fread(to.data(), 1, to.size(), from.file);
  if (present == to.size()) return {};
  return from.bad(fmt::format("{} bytes of pixels can be read", next * frame_bytes() + present),
                  fmt::format("{}", all_bytes()));
}

Result<void> SequencePixels::Reading::read_compressed(std::span<std::uint8_t> to) {
  std::uint64_t written = 0;
  while (written < to.size()) {
    written += inflater->inflate_some(to.subspan(written));
    const std::uint64_t sum = next * frame_bytes() + written;
    if (inflater->status() == Z_STREAM_END && written < to.size())
      return from.bad(fmt::format("its compressed pixels are {} bytes", sum), fmt::format("{}", all_bytes()));
    if (inflater->status() != Z_STREAM_END && inflater->status() != Z_OK) {
      return from.bad(fmt::format("its compressed pixels are damaged or cut off after {} bytes", sum),
                      fmt::format("{} bytes", all_bytes()));
    }
  }
  return {};
}

SequencePixels::SequencePixels(std::unique_ptr<Reading> reading) : reading_(std::move(reading)) {}
SequencePixels::SequencePixels(SequencePixels&&) noexcept = default;
SequencePixels& SequencePixels::operator=(SequencePixels&&) noexcept = default;
SequencePixels::~SequencePixels() = default;

Result<void> SequencePixels::read(std::uint64_t frame, std::span<std::uint8_t> to) {
  Reading& reading = *reading_;
  const bool arranged = reading.orientation != ImageOrientation{};
  if (auto there = reading.go_to(frame); !there) return there;
  while (reading.next <= frame) {
    // Frames before the one that is wanted are read over it.
    const std::span grey = arranged ? std::span(reading.in_order) : to;
    auto read = reading.read_stored(reading.levels ? std::span(reading.stored) : grey);
    if (!read) {
      reading.next = Reading::kNowhere;  // the place in the file is not known
      return read;
    }
    if (reading.levels) reading.levels->convert(reading.stored, grey);
    if (reading.next++ == 0) reading.judge_layout(grey);
  }
  if (arranged) arrange_frame(reading.in_order, reading.orientation, {reading.columns, reading.rows}, to);
  return {};
}

void SequencePixels::set_window(const ValueWindow& window) {
  reading_->levels.emplace(reading_->format, window, reading_->unscanned_code);
  reading_->stored.resize(reading_->frame_bytes());
}

UnscannedPixels SequencePixels::mark_unscanned(Unscanned wanted) {
  if (!reading_->reader) return {};
  UnscannedPixels found = reading_->reader->mark_unscanned(wanted);
  reading_->unscanned_code = found.code;
  if (found.code) set_window(whole_window(reading_->format));
  return found;
}

Result<void> SequencePixels::count(std::uint64_t frame, ValueHistogram& histogram) {
  Reading& reading = *reading_;
  reading.stored.resize(reading.frame_bytes());
  for (; reading.next <= frame; ++reading.next) {
    if (auto read = reading.read_stored(reading.stored); !read) return read;
  }
  histogram.add(reading.stored, reading.unscanned_code);
  return {};
}

bool SequencePixels::looks_transposed() const {
  return reading_->transposed;
}

bool SequencePixels::at_end() const {
  return reading_->next == reading_->frames;
}

bool SequencePixels::has_quick_access() const {
  return !reading_->inflater;
}

FileChange SequencePixels::change() const {
  if (reading_->reader) return FileChange::kNone;  // what is missing is reported when it is read
  struct stat now {};
  if (fstat(fileno(reading_->from.file), &now) != 0) return FileChange::kChanged;
  if (now.st_nlink == 0) return FileChange::kRemoved;
  const struct stat& then = reading_->opened_as;
  const bool same = now.st_size == then.st_size && now.st_mtim.tv_sec == then.st_mtim.tv_sec &&
                    now.st_mtim.tv_nsec == then.st_mtim.tv_nsec;
  return same ? FileChange::kNone : FileChange::kChanged;
}

Result<void> SequencePixels::finish() {
  Reading& reading = *reading_;
  if (!reading.inflater) return {};
  std::uint8_t beyond = 0;
  // The end of the stream may come with the last byte, or after it.
  while (reading.inflater->status() == Z_OK) {
    if (reading.inflater->inflate_some(std::span(&beyond, 1)) > 0) {
      return reading.from.bad("its compressed pixels are more than its DimSize",
                              fmt::format("{} bytes", reading.all_bytes()));
    }
  }
  if (reading.inflater->status() == Z_STREAM_END) return {};
  return reading.from.bad(
      fmt::format("its compressed pixels are damaged or cut off after {} bytes", reading.all_bytes()),
      fmt::format("{} bytes", reading.all_bytes()));
}

Result<std::vector<std::uint8_t>> SequencePixels::stored_values() {
  Reading& reading = *reading_;
  std::vector<std::uint8_t> values;
  try {
    values.resize(reading.all_bytes());
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("the voxels need {} bytes, expected as much free memory", reading.all_bytes())};
  }
  for (; reading.next < reading.frames; ++reading.next) {
    const std::size_t bytes = reading.frame_bytes();
    if (auto read = reading.read_stored(std::span(values).subspan(reading.next * bytes, bytes)); !read)
      return read.error();
  }
  if (auto whole = finish(); !whole) return whole.error();
  return values;
}

}  // namespace fanlight
