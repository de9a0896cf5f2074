// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/image_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/replay/frame_fields.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/images/image_library.hpp"

namespace fanlight {

namespace {

constexpr std::array<std::string_view, 9> kPictureEndings = {".png", ".jpg", ".jpeg", ".tif", ".tiff",
                                                             ".bmp", ".pgm", ".jp2",  ".tga"};

std::string lower_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

template <std::size_t kCount>
bool has_ending(const std::filesystem::path& path, const std::array<std::string_view, kCount>& endings) {
  return std::ranges::find(endings, lower_ending(path)) != endings.end();
}

/// "frame.%04d.png" in parts.
struct Pattern {
  std::string begin;
  std::size_t digits = 0;  // at least; 0: as many as the number has
  std::string end;
};

std::optional<Pattern> pattern_in(const std::string& name) {
  const std::size_t percent = name.find('%');
  if (percent == std::string::npos) return std::nullopt;
  std::size_t at = percent + 1;
  while (at < name.size() && std::isdigit(static_cast<unsigned char>(name[at])) != 0) ++at;
  if (at == name.size() || name[at] != 'd' || at - percent > 3 || name.find('%', at) != std::string::npos)
    return std::nullopt;
  const std::string width = name.substr(percent + 1, at - percent - 1);
  return Pattern{.begin = name.substr(0, percent),
                 .digits = width.empty() ? 0 : static_cast<std::size_t>(std::stoul(width)),
                 .end = name.substr(at + 1)};
}

/// The number that a file has in its place of the pattern; nullopt: it does not fit.
std::optional<std::uint64_t> number_by(const Pattern& pattern, const std::string& name) {
  if (!name.starts_with(pattern.begin) || !name.ends_with(pattern.end) ||
      name.size() <= pattern.begin.size() + pattern.end.size())
    return std::nullopt;
  const std::string_view digits = std::string_view(name).substr(
      pattern.begin.size(), name.size() - pattern.begin.size() - pattern.end.size());
  if (digits.size() < pattern.digits ||
      !std::ranges::all_of(digits, [](unsigned char c) { return std::isdigit(c) != 0; }))
    return std::nullopt;
  return number_in<std::uint64_t>(digits);
}

/// The last number in a name; nullopt: it has none.
std::optional<std::uint64_t> last_number(const std::string& stem) {
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  const auto end = std::find_if(stem.rbegin(), stem.rend(), is_digit);
  const auto begin = std::find_if_not(end, stem.rend(), is_digit);
  return number_in<std::uint64_t>(std::string_view(begin.base(), end.base()));
}

struct NumberedFile {
  std::uint64_t number;
  std::filesystem::path path;
};

Result<std::vector<std::filesystem::path>> in_order(const std::filesystem::path& series,
                                                    std::vector<NumberedFile> files) {
  if (files.empty())
    return bad_file(series, "there are no such pictures",
                    "files such as frame.0001.png; a DICOM file is given by its own name",
                    ErrorCode::kNotFound);
  std::ranges::sort(files, {}, &NumberedFile::number);
  for (std::size_t i = 1; i < files.size(); ++i) {
    if (files[i].number == files[i - 1].number + 1) continue;
    return bad_file(series, fmt::format("picture {} is followed by {}", files[i - 1].number, files[i].number),
                    "each number once, without a gap");
  }
  std::vector<std::filesystem::path> paths;
  paths.reserve(files.size());
  for (NumberedFile& file : files) paths.push_back(std::move(file.path));
  return paths;
}

Result<std::vector<std::filesystem::path>> files_of(const std::filesystem::path& path) {
  std::error_code failure;
  const bool folder = std::filesystem::is_directory(path, failure);
  const auto pattern = pattern_in(path.filename().string());
  const auto parent = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  std::vector<NumberedFile> files;
  std::string ending;
  for (auto entry = std::filesystem::directory_iterator(folder ? path : parent, failure);
       !failure && entry != std::filesystem::directory_iterator(); entry.increment(failure)) {
    const std::filesystem::path& file = entry->path();
    std::optional<std::uint64_t> number;
    if (folder) {
      if (!has_ending(file, kPictureEndings)) continue;
      if (ending.empty()) ending = lower_ending(file);
      if (lower_ending(file) != ending)
        return bad_file(path, "there are pictures with several endings", "a folder with one series");
      number = last_number(file.stem().string());
      if (!number) return bad_file(file, "the picture has no number", "a name such as frame.0001.png");
    } else {
      number = number_by(*pattern, file.filename().string());
      if (!number) continue;
    }
    if (files.size() == FrameFields::kMostFrames)
      return bad_file(path, fmt::format("there are over {} pictures", files.size()), "fewer");
    files.push_back({*number, file});
  }
  if (failure) return bad_file(path, "the folder cannot be read", "one that exists", ErrorCode::kNotFound);
  return in_order(path, std::move(files));
}

/// A picture as grey values, of the channels that it has.
template <typename T>
void to_luminance(std::span<const T> values, std::size_t channels, std::span<T> grey) {
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const T* const pixel = values.data() + i * channels;
    grey[i] = channels < 3
                  ? pixel[0]
                  : static_cast<T>(std::lround(0.299 * pixel[0] + 0.587 * pixel[1] + 0.114 * pixel[2]));
  }
}

}  // namespace

struct ImageSeries::State {
  std::filesystem::path name;
  std::vector<std::filesystem::path> files;
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::uint64_t frames = 0;
  PixelFormat format{.big_endian = std::endian::native == std::endian::big};
  std::vector<std::uint8_t> values;  // with all channels

  Result<void> look();
  Result<void> read(std::uint64_t frame, std::span<std::uint8_t> to);
};

Result<void> ImageSeries::State::look() {
  const auto library = image_library();
  if (!library) return library.error();
  const auto picture = (*library)->open(files.front().string());
  if (!picture) {
    return bad_file(files.front(), "the picture cannot be read (" + in_quotes(picture.error().message) + ")",
                    "a picture or video of a usual format", ErrorCode::kUnsupported);
  }
  const ImageShape shape = (*picture)->shape();
  if (shape.width < 2 || shape.height < 2 || shape.width > static_cast<int>(FrameFields::kMostSide) ||
      shape.height > static_cast<int>(FrameFields::kMostSide) || shape.channels < 1 || shape.depth > 1) {
    return bad_file(files.front(), fmt::format("it has {} x {} pixels", shape.width, shape.height),
                    fmt::format("2 to {} on each side", FrameFields::kMostSide));
  }
  columns = static_cast<std::uint32_t>(shape.width);
  rows = static_cast<std::uint32_t>(shape.height);
  format.bytes = shape.bytes_per_value;
  frames = files.size();
  return {};
}

ImageSeries::ImageSeries(std::unique_ptr<State> state) : state_(std::move(state)) {}
ImageSeries::~ImageSeries() = default;

bool ImageSeries::is_series(const std::filesystem::path& path) {
  std::error_code failure;
  if (std::filesystem::is_directory(path, failure)) return true;
  return has_ending(path, kPictureEndings) && pattern_in(path.filename().string());
}

Result<std::unique_ptr<ImageSeries>> ImageSeries::open(const std::filesystem::path& path) {
  auto state = std::make_unique<State>();
  state->name = path;
  auto files = files_of(path);
  if (!files) return files.error();
  state->files = *std::move(files);
  if (auto looked = state->look(); !looked) return looked.error();
  return std::unique_ptr<ImageSeries>(new ImageSeries(std::move(state)));
}

std::uint32_t ImageSeries::columns() const {
  return state_->columns;
}
std::uint32_t ImageSeries::rows() const {
  return state_->rows;
}
std::uint64_t ImageSeries::frames() const {
  return state_->frames;
}
PixelFormat ImageSeries::format() const {
  return state_->format;
}
Result<void> ImageSeries::read(std::uint64_t frame, std::span<std::uint8_t> to) {
  return state_->read(frame, to);
}

Result<void> ImageSeries::State::read(std::uint64_t frame, std::span<std::uint8_t> to) {
  const auto& file = files[frame];
  const auto library = image_library();
  if (!library) return library.error();
  const auto picture = (*library)->open(file.string());
  if (!picture)
    return bad_file(file, fmt::format("frame {} cannot be read", frame), "as many as were there at first");
  const ImageShape shape = (*picture)->shape();
  if (shape.width != static_cast<int>(columns) || shape.height != static_cast<int>(rows) ||
      shape.channels < 1 || shape.channels > 8) {
    return bad_file(file, fmt::format("frame {} has {} x {} pixels", frame, shape.width, shape.height),
                    fmt::format("{} x {}, as the first", columns, rows));
  }
  const std::size_t pixels = std::size_t{columns} * rows;
  const auto channels = static_cast<std::size_t>(shape.channels);
  values.resize(pixels * channels * format.bytes);
  if (const auto read_all = (*picture)->read(format.bytes, values); !read_all) {
    return bad_file(file, fmt::format("frame {} is damaged ({})", frame, in_quotes(read_all.error().message)),
                    "a whole picture");
  }
  if (format.bytes == 1) {
    to_luminance<std::uint8_t>(values, channels, to);
  } else {
    const std::span wide(reinterpret_cast<const std::uint16_t*>(values.data()), pixels * channels);
    to_luminance<std::uint16_t>(wide, channels, {reinterpret_cast<std::uint16_t*>(to.data()), pixels});
  }
  return {};
}

Result<FrameSequence> series_frames(const std::filesystem::path& path, const ImageSeries& series,
                                    std::uint64_t max_bytes) {
  FrameSequence sequence;
  sequence.columns = series.columns();
  sequence.rows = series.rows();
  sequence.compressed = true;
  sequence.format = series.format();
  if (sequence.frame_bytes() * series.frames() > max_bytes) {
    return bad_file(path,
                    fmt::format("its {} frames have {} bytes of pixels", series.frames(),
                                sequence.frame_bytes() * series.frames()),
                    fmt::format("at most {}", max_bytes));
  }
  sequence.frames.resize(series.frames());
  return sequence;
}

}  // namespace fanlight
