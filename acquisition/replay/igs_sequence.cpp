// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/igs_sequence.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <new>
#include <utility>
#include <vector>

#include "acquisition/replay/file_kind.hpp"
#include "acquisition/replay/igs_header.hpp"
#include "acquisition/replay/image_orientation.hpp"
#include "acquisition/replay/image_series.hpp"
#include "acquisition/replay/inflater.hpp"
#include "acquisition/replay/kretz_header.hpp"
#include "acquisition/replay/nrrd_header.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

struct OpenedFile {
  File file;
  IgsFile from;
};

struct OpenedHeader {
  OpenedFile pixels;  ///< at the first byte of the pixels
  std::uint64_t pixel_bytes = 0;
  IgsHeader header;
};

Result<OpenedFile> open_file(const std::filesystem::path& path) {
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
  IgsFile from{.name = shown(path), .file = file.get(), .bytes = bytes};
  if (bytes == 0) return from.bad("the file is empty", "a MetaImage sequence");
  return OpenedFile{.file = std::move(file), .from = std::move(from)};
}

Result<IgsHeader> read_header(const IgsFile& from, std::string_view first_bytes) {
  if (first_bytes.starts_with("NRRD000")) return read_nrrd_header(from);
  if (first_bytes.starts_with("KRETZFILE")) return read_kretz_header(from);
  return read_igs_header(from);
}

Result<OpenedHeader> open_header(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto text = open_file(path);
  if (!text) return text.error();
  const IgsFile& from = text->from;
  std::array<unsigned char, 400> first{};
  const std::size_t read = std::fread(first.data(), 1, first.size(), from.file);
  if (const auto foreign = foreign_format(std::span(first).first(read), path)) {
    return from.bad(fmt::format("this is {}", foreign->what), foreign->advice, ErrorCode::kUnsupported);
  }
  std::rewind(from.file);
  auto header = read_header(from, {reinterpret_cast<const char*>(first.data()), read});
  if (!header) return header.error();
  OpenedHeader opened{
      .pixels = {}, .pixel_bytes = from.bytes - header->header_bytes, .header = *std::move(header)};
  if (opened.header.data_file.empty()) {
    // What follows the pixels may have been read too.
    if (std::fseek(from.file, static_cast<long>(opened.header.header_bytes), SEEK_SET) != 0)
      return from.bad("the file cannot be read on", "a file that can");
    opened.pixels = *std::move(text);
  } else {
    auto pixels = open_file(path.parent_path() / opened.header.data_file);
    if (!pixels) return pixels.error();
    opened.pixels = *std::move(pixels);
    opened.pixel_bytes = opened.pixels.from.bytes;
  }
  const auto complete = complete_frames(opened.pixels.from, opened.header, opened.pixel_bytes, max_bytes);
  if (!complete) return complete.error();
  return opened;
}

}  // namespace

/// The file behind its header, and where the reading is.
struct IgsPixels::Reading {
  static constexpr std::uint64_t kNowhere = std::numeric_limits<std::uint64_t>::max();
  File file;
  IgsFile from;
  ImageOrientation orientation;
  std::uint32_t columns = 0;  // after arranging
  std::uint32_t rows = 0;
  std::uint64_t frames = 0;
  std::uint64_t next = 0;  // frame
  bool transposed = false;
  PixelFormat format;
  std::optional<GreyLevels> levels;    // absent: the stored values are grey levels
  std::optional<Inflater> inflater;    // absent: plain pixels
  std::vector<std::uint8_t> stored;    // a frame as in the file, where it is not grey levels
  std::vector<std::uint8_t> in_order;  // a frame of grey levels in the file's axis order
  long first_pixel = 0;                // offset in the file
  std::uint64_t compressed_bytes = 0;
  bool gzip = false;
  struct stat opened_as {};
  std::optional<ImageSeries> series;  // then there is no file

  /// Of the file.
  std::uint64_t frame_bytes() const { return std::uint64_t{columns} * rows * format.bytes; }
  std::uint64_t all_bytes() const { return frame_bytes() * frames; }
  Result<void> read_stored(std::span<std::uint8_t> to) {
    if (series) return series->read(next, to);
    return inflater ? read_compressed(to) : read_plain(to);
  }
  Result<void> go_to(std::uint64_t frame);
  Result<void> read_plain(std::span<std::uint8_t> to);
  Result<void> read_compressed(std::span<std::uint8_t> to);
  void judge_layout(std::span<const std::uint8_t> frame);
};

/// In an image neighbours below each other are alike. Where pixels that are `rows` apart in the file are much
/// more alike than those that are `columns` apart, the two were exchanged.
void IgsPixels::Reading::judge_layout(std::span<const std::uint8_t> frame) {
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
Result<void> IgsPixels::Reading::go_to(std::uint64_t frame) {
  if (frame == next || (inflater && frame > next)) return {};
  if (series) {
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

Result<void> IgsPixels::Reading::read_plain(std::span<std::uint8_t> to) {
  const std::uint64_t present = std::fread(to.data(), 1, to.size(), from.file);
  if (present == to.size()) return {};
  return from.bad(fmt::format("{} bytes of pixels can be read", next * frame_bytes() + present),
                  fmt::format("{}", all_bytes()));
}

Result<void> IgsPixels::Reading::read_compressed(std::span<std::uint8_t> to) {
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

IgsPixels::IgsPixels(std::unique_ptr<Reading> reading) : reading_(std::move(reading)) {}
IgsPixels::IgsPixels(IgsPixels&&) noexcept = default;
IgsPixels& IgsPixels::operator=(IgsPixels&&) noexcept = default;
IgsPixels::~IgsPixels() = default;

Result<void> IgsPixels::read(std::uint64_t frame, std::span<std::uint8_t> to) {
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

void IgsPixels::set_window(const ValueWindow& window) {
  reading_->levels.emplace(reading_->format, window);
  reading_->stored.resize(reading_->frame_bytes());
}

Result<void> IgsPixels::count(std::uint64_t frame, ValueHistogram& histogram) {
  Reading& reading = *reading_;
  reading.stored.resize(reading.frame_bytes());
  for (; reading.next <= frame; ++reading.next) {
    if (auto read = reading.read_stored(reading.stored); !read) return read;
  }
  histogram.add(reading.stored);
  return {};
}

Result<ValueWindow> choose_window(const std::filesystem::path& path, std::uint64_t max_bytes) {
  constexpr std::size_t kMostFrames = 64;
  auto opened = open_igs_sequence(path, max_bytes);
  if (!opened) return opened.error();
  ValueHistogram histogram(opened->sequence.format);
  const std::size_t frames = opened->sequence.frames.size();
  const std::size_t step = std::max<std::size_t>(1, frames / kMostFrames);
  for (std::size_t frame = 0; frame < frames; frame += step) {
    if (auto counted = opened->pixels.count(frame, histogram); !counted) return counted.error();
  }
  return histogram.window();
}

bool IgsPixels::looks_transposed() const {
  return reading_->transposed;
}

bool IgsPixels::at_end() const {
  return reading_->next == reading_->frames;
}

bool IgsPixels::has_quick_access() const {
  return !reading_->inflater;
}

FileChange IgsPixels::change() const {
  if (reading_->series) return FileChange::kNone;  // a picture that has gone is told when it is read
  struct stat now {};
  if (fstat(fileno(reading_->from.file), &now) != 0) return FileChange::kChanged;
  if (now.st_nlink == 0) return FileChange::kRemoved;
  const struct stat& then = reading_->opened_as;
  const bool same = now.st_size == then.st_size && now.st_mtim.tv_sec == then.st_mtim.tv_sec &&
                    now.st_mtim.tv_nsec == then.st_mtim.tv_nsec;
  return same ? FileChange::kNone : FileChange::kChanged;
}

Result<void> IgsPixels::finish() {
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

namespace {

Result<OpenedSequence> open_series(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto series = ImageSeries::open(path);
  if (!series) return series.error();
  auto sequence = series_frames(path, *series, max_bytes);
  if (!sequence) return sequence.error();
  auto reading = std::make_unique<IgsPixels::Reading>();
  reading->columns = sequence->columns;
  reading->rows = sequence->rows;
  reading->frames = sequence->frames.size();
  reading->format = sequence->format;
  reading->series = *std::move(series);
  const PixelFormat format = sequence->format;
  OpenedSequence opened{
      .sequence = *std::move(sequence), .pixels = IgsPixels(std::move(reading)), .orientation = {}};
  if (!format.is_grey()) opened.pixels.set_window(whole_window(format));
  return opened;
}

}  // namespace

Result<OpenedSequence> open_igs_sequence(const std::filesystem::path& path, std::uint64_t max_bytes) {
  if (ImageSeries::is_series(path)) return open_series(path, max_bytes);
  auto opened = open_header(path, max_bytes);
  if (!opened) return opened.error();
  IgsHeader& header = opened->header;
  IgsSequence& sequence = header.sequence;
  if (header.orientation.lines_in_rows) {
    std::swap(sequence.columns, sequence.rows);
    if (sequence.pixel_size) std::swap(sequence.pixel_size->width_mm, sequence.pixel_size->height_mm);
  }
  auto reading = std::make_unique<IgsPixels::Reading>();
  reading->from = opened->pixels.from;
  reading->orientation = header.orientation;
  reading->columns = sequence.columns;
  reading->rows = sequence.rows;
  reading->frames = sequence.frames.size();
  reading->format = sequence.format = header.format;
  reading->in_order.resize(header.orientation == ImageOrientation{} ? 0 : sequence.frame_bytes());
  reading->first_pixel = std::ftell(opened->pixels.file.get());
  if (reading->first_pixel < 0 || fstat(fileno(opened->pixels.file.get()), &reading->opened_as) != 0)
    return reading->from.bad("the file cannot be read on", "a file that can");
  if (sequence.compressed) {
    reading->compressed_bytes = header.compressed_bytes.value_or(opened->pixel_bytes);
    reading->gzip = header.gzip;
    reading->inflater.emplace(opened->pixels.file.get(), reading->compressed_bytes);
    if (!reading->inflater->start(header.gzip))
      return reading->from.bad("zlib cannot start", "free memory", ErrorCode::kUnavailable);
  }
  reading->file = std::move(opened->pixels.file);
  OpenedSequence result{.sequence = std::move(sequence),
                        .pixels = IgsPixels(std::move(reading)),
                        .orientation = header.orientation};
  if (!header.format.is_grey()) result.pixels.set_window(whole_window(header.format));
  return result;
}

Result<IgsSequence> read_igs_sequence(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto opened = open_igs_sequence(path, max_bytes);
  if (!opened) return opened.error();
  if (auto read = read_all(*opened); !read) return read.error();
  return std::move(opened->sequence);
}

Result<void> read_all(OpenedSequence& opened) {
  IgsSequence& sequence = opened.sequence;
  const std::uint64_t bytes = sequence.frame_bytes() * sequence.frames.size();
  sequence.pixels.reset(new (std::nothrow) std::uint8_t[bytes]);
  if (sequence.pixels == nullptr) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("the recording's pixels need {} bytes, expected as much free memory", bytes)};
  }
  for (std::size_t frame = 0; frame < sequence.frames.size(); ++frame) {
    const std::span to(sequence.pixels.get() + frame * sequence.frame_bytes(), sequence.frame_bytes());
    if (auto read = opened.pixels.read(frame, to); !read) return read;
  }
  return opened.pixels.finish();
}

}  // namespace fanlight
