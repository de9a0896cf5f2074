// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/recording_file.hpp"

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

#ifdef FANLIGHT_DICOM
#include "acquisition/replay/dicom_file.hpp"
#endif
#include "acquisition/replay/foreign_format.hpp"
#include "acquisition/replay/image_series.hpp"
#include "acquisition/replay/kretz_header.hpp"
#include "acquisition/replay/nifti_file.hpp"
#include "acquisition/replay/nrrd_header.hpp"
#include "acquisition/replay/pixel_reading.hpp"
#include "acquisition/replay/sequence_header.hpp"
#include "acquisition/sequence/image_orientation.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

// By which the format of a file is recognised; see foreign_format().
constexpr std::size_t kSniffedBytes = 400;

struct OpenedFile {
  File file;
  NamedFile from;
};

struct OpenedHeader {
  OpenedFile pixels;  ///< at the first byte of the pixels
  std::uint64_t pixel_bytes = 0;
  SequenceHeader header;
};

Result<OpenedFile> open_file(const std::filesystem::path& path) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status)) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{}: there is no such file, expected a recording", shown(path))};
  }
  // Opening a pipe would block until its other end is opened.
  if (!std::filesystem::is_regular_file(status)) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("{}: this is no regular file, expected a recording", shown(path))};
  }
  const std::uint64_t bytes = std::filesystem::file_size(path, failure);
  File file(failure ? nullptr : std::fopen(path.c_str(), "rbe"));
  if (file == nullptr) {
    return Error{
        ErrorCode::kUnavailable,
        fmt::format("{}: the file cannot be opened, expected one that this user may read", shown(path))};
  }
  NamedFile from{.name = shown(path), .file = file.get(), .bytes = bytes};
  if (bytes == 0) return from.bad("the file is empty", "a recording");
  return OpenedFile{.file = std::move(file), .from = std::move(from)};
}

/// Reads the text of a header and checks it.
using ReadHeader = Result<SequenceHeader> (*)(const NamedFile& from);

Result<OpenedHeader> open_header(ReadHeader read_header, const std::filesystem::path& path,
                                 std::uint64_t max_bytes) {
  auto text = open_file(path);
  if (!text) return text.error();
  const NamedFile& from = text->from;
  std::array<unsigned char, kSniffedBytes> first{};
  const std::size_t read = std::fread(first.data(), 1, first.size(), from.file);
  if (const auto foreign = foreign_format(std::span(first).first(read), path)) {
    return from.bad(fmt::format("this is {}", foreign->what), foreign->advice, ErrorCode::kUnsupported);
  }
  std::rewind(from.file);
  auto header = read_header(from);
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

OpenedSequence with_reader(FrameSequence sequence, std::unique_ptr<FrameReader> reader,
                           const ImageOrientation& orientation = {}) {
  auto reading = std::make_unique<SequencePixels::Reading>();
  reading->columns = sequence.columns;
  reading->rows = sequence.rows;
  reading->frames = sequence.frames.size();
  reading->format = sequence.format;
  reading->reader = std::move(reader);
  reading->orientation = orientation;
  reading->in_order.resize(orientation == ImageOrientation{} ? 0 : sequence.frame_bytes());
  const PixelFormat format = sequence.format;
  OpenedSequence opened{.sequence = std::move(sequence),
                        .pixels = SequencePixels(std::move(reading)),
                        .orientation = orientation};
  if (!format.is_grey()) opened.pixels.set_window(whole_window(format));
  return opened;
}

Result<OpenedSequence> open_series(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto series = ImageSeries::open(path);
  if (!series) return series.error();
  auto sequence = series_frames(path, **series, max_bytes);
  if (!sequence) return sequence.error();
  return with_reader(*std::move(sequence), *std::move(series));
}

/// `voxels` of all volumes; `notes` go before those on the grid.
OpenedSequence grid_sequence(const VoxelGrid& grid, PixelFormat format, std::vector<std::uint8_t> voxels,
                             const std::vector<std::string>& notes) {
  FrameSequence sequence = fan_through(grid, format);
  sequence.notes.insert(sequence.notes.end(), notes.begin(), notes.end());
  return with_reader(std::move(sequence), fan_reader(grid, format, std::move(voxels)));
}

/// Volumes on a grid, whose slices are read.
Result<OpenedSequence> open_grid(SequencePixels slices, const FrameSequence& sequence,
                                 const VoxelGrid& grid) {
  auto voxels = slices.stored_values();
  if (!voxels) return voxels.error();
  return grid_sequence(grid, sequence.format, *std::move(voxels), sequence.notes);
}

/// Frames in memory, one behind the other.
class FramesInMemory : public FrameReader {
 public:
  explicit FramesInMemory(std::vector<std::uint8_t> frames) : frames_(std::move(frames)) {}
  Result<void> read(std::uint64_t frame, std::span<std::uint8_t> to) override {
    std::ranges::copy(std::span(frames_).subspan(frame * to.size(), to.size()), to.begin());
    return {};
  }

 private:
  std::vector<std::uint8_t> frames_;
};

/// Puts the values of each item of a list behind each other.
std::vector<std::uint8_t> not_interleaved(std::vector<std::uint8_t> values, std::size_t items,
                                          std::size_t value_bytes) {
  std::vector<std::uint8_t> ordered(values.size());
  const std::size_t in_item = values.size() / value_bytes / items;
  for (std::size_t value = 0; value < in_item; ++value) {
    for (std::size_t item = 0; item < items; ++item) {
      const std::uint8_t* const from = values.data() + (value * items + item) * value_bytes;
      std::copy_n(from, value_bytes, ordered.data() + (item * in_item + value) * value_bytes);
    }
  }
  return ordered;
}

Result<OpenedSequence> open_frames_first(SequencePixels pixels, SequenceHeader header) {
  auto values = pixels.stored_values();
  if (!values) return values.error();
  const std::size_t items = header.grid ? header.grid->volumes : header.sequence.frames.size();
  auto ordered = not_interleaved(*std::move(values), items, header.format.bytes);
  if (header.grid)
    return grid_sequence(*header.grid, header.format, std::move(ordered), header.sequence.notes);
  return with_reader(std::move(header.sequence), std::make_unique<FramesInMemory>(std::move(ordered)),
                     header.orientation);
}

Result<OpenedSequence> open_pixels(OpenedHeader opened) {
  SequenceHeader& header = opened.header;
  FrameSequence& sequence = header.sequence;
  if (header.orientation.lines_in_rows) {
    std::swap(sequence.columns, sequence.rows);
    if (sequence.pixel_size) std::swap(sequence.pixel_size->width_mm, sequence.pixel_size->height_mm);
  }
  auto reading = std::make_unique<SequencePixels::Reading>();
  reading->from = opened.pixels.from;
  reading->orientation = header.orientation;
  reading->columns = sequence.columns;
  reading->rows = sequence.rows;
  reading->frames = sequence.frames.size();
  reading->format = sequence.format = header.format;
  reading->in_order.resize(header.orientation == ImageOrientation{} ? 0 : sequence.frame_bytes());
  reading->first_pixel = std::ftell(opened.pixels.file.get());
  if (reading->first_pixel < 0 || fstat(fileno(opened.pixels.file.get()), &reading->opened_as) != 0)
    return reading->from.bad("the file cannot be read on", "a file that can");
  if (sequence.compressed) {
    reading->compressed_bytes = header.compressed_bytes.value_or(opened.pixel_bytes);
    reading->gzip = header.gzip;
    reading->inflater.emplace(opened.pixels.file.get(), reading->compressed_bytes);
    if (!reading->inflater->start(header.gzip))
      return reading->from.bad("zlib cannot start", "free memory", ErrorCode::kUnavailable);
  }
  reading->file = std::move(opened.pixels.file);
  if (header.frames_first) return open_frames_first(SequencePixels(std::move(reading)), std::move(header));
  if (header.grid) return open_grid(SequencePixels(std::move(reading)), sequence, *header.grid);
  OpenedSequence result{.sequence = std::move(sequence),
                        .pixels = SequencePixels(std::move(reading)),
                        .orientation = header.orientation};
  if (!header.format.is_grey()) result.pixels.set_window(whole_window(header.format));
  return result;
}

#ifdef FANLIGHT_DICOM
Result<OpenedSequence> open_dicom_sequence(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto dicom = open_dicom(path, max_bytes);
  if (!dicom) return dicom.error();
  OpenedSequence opened = with_reader(std::move(dicom->sequence), std::move(dicom->reader));
  if (!dicom->grid) return opened;
  if (auto fits = check(*dicom->grid, shown(path)); !fits) return fits.error();
  return open_grid(std::move(opened.pixels), opened.sequence, *dicom->grid);
}
#endif

Result<OpenedSequence> open_nifti(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto nifti = read_nifti(path, max_bytes);
  if (!nifti) return nifti.error();
  return grid_sequence(nifti->grid, nifti->format, std::move(nifti->voxels), nifti->notes);
}

/// A file with a header of text and pixels behind it, or in another file.
template <ReadHeader read_header>
Result<OpenedSequence> open_with_header(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto opened = open_header(read_header, path, max_bytes);
  if (!opened) return opened.error();
  return open_pixels(*std::move(opened));
}

Result<std::vector<std::filesystem::path>> only_file(const std::filesystem::path& path) {
  return std::vector{path};
}

template <ReadHeader read_header>
Result<std::vector<std::filesystem::path>> header_and_data_file(const std::filesystem::path& path) {
  const auto opened = open_header(read_header, path, std::numeric_limits<std::uint64_t>::max());
  if (!opened) return opened.error();
  if (opened->header.data_file.empty()) return std::vector{path};
  return std::vector{path, path.parent_path() / opened->header.data_file};
}

/// All files of the folder, by name.
Result<std::vector<std::filesystem::path>> files_of_series(const std::filesystem::path& path) {
  std::error_code failure;
  std::filesystem::path folder = std::filesystem::is_directory(path, failure) ? path : path.parent_path();
  if (folder.empty()) folder = ".";
  std::vector<std::filesystem::path> files;
  for (std::filesystem::directory_iterator each(folder, failure), end; !failure && each != end;
       each.increment(failure)) {
    std::error_code unknown;
    if (each->is_regular_file(unknown)) files.push_back(each->path());
  }
  if (failure) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{}: the folder cannot be read ({}), expected one with pictures", shown(path),
                             failure.message())};
  }
  std::ranges::sort(files);
  return files;
}

/// A path, and the first bytes of the file where it is one that can be read.
struct Sniffed {
  const std::filesystem::path& path;
  std::span<const unsigned char> first_bytes;

  bool begins_with(std::string_view magic) const {
    return std::string_view(reinterpret_cast<const char*>(first_bytes.data()), first_bytes.size())
        .starts_with(magic);
  }
};

/// A format that Fanlight reads. Another format is another row.
struct Format {
  bool (*is)(const Sniffed& file);
  Result<OpenedSequence> (*open)(const std::filesystem::path& path, std::uint64_t max_bytes);
  Result<std::vector<std::filesystem::path>> (*files)(const std::filesystem::path& path);
};

constexpr Format kFormats[] = {
    {[](const Sniffed& file) { return ImageSeries::is_series(file.path); }, open_series, files_of_series},
#ifdef FANLIGHT_DICOM
    {[](const Sniffed& file) { return is_dicom(file.first_bytes); }, open_dicom_sequence, only_file},
#endif
    {[](const Sniffed& file) { return is_nifti(file.path, file.first_bytes); }, open_nifti, only_file},
    {[](const Sniffed& file) { return file.begins_with("NRRD000"); }, open_with_header<read_nrrd_header>,
     header_and_data_file<read_nrrd_header>},
    {[](const Sniffed& file) { return file.begins_with("KRETZFILE"); }, open_with_header<read_kretz_header>,
     header_and_data_file<read_kretz_header>},
    // All else; open_header() has refused files of formats that are not read.
    {[](const Sniffed&) { return true; }, open_with_header<read_meta_image_header>,
     header_and_data_file<read_meta_image_header>},
};

const Format& format_of(const std::filesystem::path& path) {
  std::array<unsigned char, kSniffedBytes> first{};
  std::size_t read = 0;
  if (const auto opened = open_file(path))
    read = std::fread(first.data(), 1, first.size(), opened->from.file);
  const Sniffed file{.path = path, .first_bytes = std::span(first).first(read)};
  return *std::ranges::find_if(kFormats, [&](const Format& each) { return each.is(file); });
}

}  // namespace

Result<std::vector<std::filesystem::path>> recording_files(const std::filesystem::path& path) {
  return format_of(path).files(path);
}

Result<OpenedSequence> open_recording_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  return format_of(path).open(path, max_bytes);
}

Result<ValueWindow> choose_window(const std::filesystem::path& path, std::uint64_t max_bytes,
                                  Unscanned unscanned) {
  constexpr std::size_t kMostFramesRead = 64;
  auto opened = open_recording_file(path, max_bytes);
  if (!opened) return opened.error();
  if (unscanned != Unscanned::kNone) opened->pixels.mark_unscanned(unscanned);
  ValueHistogram histogram(opened->sequence.format);
  const std::size_t frames = opened->sequence.frames.size();
  const std::size_t step = std::max<std::size_t>(1, frames / kMostFramesRead);
  for (std::size_t frame = 0; frame < frames; frame += step) {
    if (auto counted = opened->pixels.count(frame, histogram); !counted) return counted.error();
  }
  return histogram.window();
}

Result<FrameSequence> read_recording_file(const std::filesystem::path& path, std::uint64_t max_bytes) {
  auto opened = open_recording_file(path, max_bytes);
  if (!opened) return opened.error();
  if (auto read = read_all(*opened); !read) return read.error();
  return std::move(opened->sequence);
}

Result<void> read_all(OpenedSequence& opened) {
  FrameSequence& sequence = opened.sequence;
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
