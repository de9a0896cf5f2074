#include "acquisition/igs_sequence.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <new>
#include <string_view>
#include <utility>

#include "acquisition/image_orientation.hpp"
#include "acquisition/text.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kLongestLine = 65'536;
constexpr std::uint32_t kMostSide = 4096;
constexpr std::uint32_t kMostFrames = 1'000'000;
constexpr std::size_t kMostFanlightFields = 64;
constexpr std::size_t kChunkBytes = 262'144;
// Deflate's best: a byte of input stands for no more than this many bytes of output.
constexpr std::uint64_t kMostInflation = 1032;
constexpr std::string_view kOrientations = "MF, MN, UF, UN, FM, FU, NM or NU, with or without A or D behind";

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

/// Reads one file from its first byte to its last.
class SequenceReader {
 public:
  SequenceReader(const std::filesystem::path& path, File file, std::uint64_t file_bytes,
                 std::uint64_t max_bytes)
      : name_(shown(path)), file_(std::move(file)), file_bytes_(file_bytes), max_bytes_(max_bytes) {}

  Result<IgsSequence> read() {
    if (file_bytes_ == 0) return bad("the file is empty", "a MetaImage sequence");
    if (const auto done = read_header(); !done) return done.error();
    if (const auto done = check_header(); !done) return done.error();
    if (const auto done = allocate_pixels(); !done) return done.error();
    if (const auto done = sequence_.compressed ? read_compressed() : read_plain(); !done) return done.error();
    if (const auto done = arrange_frames(); !done) return done.error();
    return std::move(sequence_);
  }

 private:
  struct Line {
    std::string_view key;
    std::string_view value;
  };

  Error bad(std::string_view wrong, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const {
    return {code, fmt::format("{}: {}, expected {}", name_, wrong, expected)};
  }
  Error unsupported(std::string_view wrong, std::string_view expected) const {
    return bad(wrong, expected, ErrorCode::kUnsupported);
  }
  Error refused(const Line& line, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const {
    return bad(fmt::format("{} is {}", in_quotes(line.key), in_quotes(line.value)), expected, code);
  }

  Result<void> read_header() {
    for (;;) {
      const auto line = next_line();
      if (!line) return line.error();
      if (line->key == "ElementDataFile") {
        if (line->value == "LOCAL") return {};
        return refused(*line, "LOCAL (pixels in the same file)", ErrorCode::kUnsupported);
      }
      const auto taken = line->key.starts_with(kFramePrefix) ? take_frame_field(*line) : take_field(*line);
      if (!taken) return taken.error();
    }
  }

  /// The next line, in line_ until the next call.
  Result<Line> next_line() {
    ++line_number_;
    line_.clear();
    for (;;) {
      const int c = std::getc(file_.get());
      if (c == EOF) return bad("the header ends too early", "a last line ElementDataFile = LOCAL");
      ++header_bytes_;
      if (c == '\n') break;
      const bool control = c < ' ' && c != '\t' && c != '\r';
      if (control || c == 0x7F) {
        return bad(fmt::format("line {} of the header holds byte {:#04x}", line_number_, c), "text");
      }
      if (line_.size() == kLongestLine) {
        return bad(fmt::format("line {} of the header is longer than {} bytes", line_number_, kLongestLine),
                   "shorter lines");
      }
      line_.push_back(static_cast<char>(c));
    }
    const auto equals = line_.find('=');
    if (equals == std::string::npos) {
      return bad(fmt::format("line {} of the header is {}", line_number_, in_quotes(line_)), "Name = value");
    }
    const std::string_view text = line_;
    return Line{trimmed(text.substr(0, equals)), trimmed(text.substr(equals + 1))};
  }

  Result<void> take_field(const Line& line) {
    const auto& [key, value] = line;
    if (key == "ObjectType" && value != "Image") return refused(line, "Image", ErrorCode::kUnsupported);
    if (key == "NDims" && value != "3") {
      return refused(line, "3 (columns, rows, frames)", ErrorCode::kUnsupported);
    }
    if (key == "BinaryData" && value != "True") return refused(line, "True", ErrorCode::kUnsupported);
    if (key == "ElementNumberOfChannels" && value != "1") return refused(line, "1", ErrorCode::kUnsupported);
    if (key == "ElementType") {
      if (value != "MET_UCHAR") return refused(line, "MET_UCHAR (8 bit)", ErrorCode::kUnsupported);
      typed_ = true;
    }
    if (key == "UltrasoundImageOrientation") {
      orientation_ = ImageOrientation::from_letters(value);
      if (!orientation_) return refused(line, kOrientations, ErrorCode::kUnsupported);
    }
    if (key == "UltrasoundImageType" && value != "BRIGHTNESS") {
      return refused(line, "BRIGHTNESS", ErrorCode::kUnsupported);
    }
    if (key == "Kinds" && !value.ends_with("list") && !value.ends_with("time")) {
      return refused(line, "domain domain list (the last axis is time)", ErrorCode::kUnsupported);
    }
    if (key == "CompressedData") {
      if (value != "True" && value != "False") return refused(line, "True or False");
      sequence_.compressed = value == "True";
    }
    if (key == "CompressedDataSize") {
      compressed_bytes_ = number_in<std::uint64_t>(value);
      if (!compressed_bytes_) return refused(line, "a number of bytes");
    }
    if (key == "DimSize") return take_size(line);
    if (key.starts_with("Fanlight")) {
      if (sequence_.fanlight_fields.size() == kMostFanlightFields) {
        return bad(fmt::format("the header has more than {} Fanlight fields", kMostFanlightFields), "fewer");
      }
      sequence_.fanlight_fields.emplace(key, value);
    }
    return {};
  }

  Result<void> take_size(const Line& line) {
    constexpr std::string_view kExpected =
        "three numbers: columns and rows from 2 to 4096, frames from 1 to 1000000";
    std::array<std::uint32_t, 3> size{};
    std::string_view rest = line.value;
    for (std::uint32_t& each : size) {
      const auto word = rest.substr(0, rest.find(' '));
      const auto number = number_in<std::uint32_t>(word);
      if (!number) return refused(line, kExpected);
      each = *number;
      rest = trimmed(rest.substr(word.size()));
    }
    const auto [columns, rows, frames] = size;
    const bool fits = columns >= 2 && columns <= kMostSide && rows >= 2 && rows <= kMostSide && frames >= 1 &&
                      frames <= kMostFrames;
    if (!rest.empty() || !fits) return refused(line, kExpected);
    // Before anything is allocated by these numbers.
    const std::uint64_t bytes = std::uint64_t{columns} * rows * frames;
    if (bytes > max_bytes_) return refused(line, fmt::format("at most {} bytes of pixels", max_bytes_));
    if (bytes / kMostInflation > file_bytes_) {
      return refused(line, fmt::format("a size that a file of {} bytes can hold", file_bytes_));
    }
    sequence_.columns = columns;
    sequence_.rows = rows;
    sequence_.frames.assign(frames, {});
    return {};
  }

  Result<void> take_frame_field(const Line& line) {
    const std::string_view numbered = line.key.substr(kFramePrefix.size());
    const auto underscore = numbered.find('_');
    const auto index = number_in<std::uint32_t>(numbered.substr(0, underscore));
    if (underscore == std::string_view::npos || !index) {
      return bad(fmt::format("the header has a field {}", in_quotes(line.key)), "Seq_Frame0000_Name");
    }
    if (sequence_.frames.empty()) {
      return bad("the header describes frames before it gives a DimSize", "DimSize first");
    }
    if (*index >= sequence_.frames.size()) {
      return bad(fmt::format("the header describes frame {}", *index),
                 fmt::format("the {} frames of its DimSize, from 0", sequence_.frames.size()));
    }
    IgsFrame& frame = sequence_.frames[*index];
    const std::string_view field = numbered.substr(underscore + 1);
    if (field == "Timestamp") return take_number(line, frame.timestamp_s, "seconds");
    if (field == "MotorAngleDeg") return take_number(line, frame.motor_angle_deg, "degrees");
    if (field == "VolumeIndex") return take_number(line, frame.volume_index, "a whole number from 0");
    if (field == "FrameIndex") return take_number(line, frame.frame_index, "a whole number from 0");
    if (field == "ImageToReferenceTransform" && !sequence_.pixel_size) return take_transform(line);
    if (field == "ImageStatus") {
      if (line.value != "OK" && line.value != "INVALID") return refused(line, "OK or INVALID");
      frame.valid = line.value == "OK";
    }
    if (field == "SweepDirection") {
      if (line.value != "FORWARD" && line.value != "BACKWARD") return refused(line, "FORWARD or BACKWARD");
      frame.direction = line.value == "FORWARD" ? SweepDirection::kForward : SweepDirection::kBackward;
    }
    return {};
  }

  template <typename T>
  Result<void> take_number(const Line& line, std::optional<T>& number, std::string_view expected) const {
    number = number_in<T>(line.value);
    if (!number) return refused(line, expected);
    return {};
  }

  /// The lengths of the matrix's first two columns: mm along the image's x and y axes.
  Result<void> take_transform(const Line& line) {
    std::array<double, 16> matrix{};  // row order
    std::string_view rest = line.value;
    for (double& element : matrix) {
      const auto word = rest.substr(0, rest.find(' '));
      const auto number = number_in<double>(word);
      if (!number) return refused(line, "a matrix of 16 numbers");
      element = *number;
      rest = trimmed(rest.substr(word.size()));
    }
    sequence_.pixel_size = {.width_mm = std::hypot(matrix[0], matrix[4], matrix[8]),
                            .height_mm = std::hypot(matrix[1], matrix[5], matrix[9])};
    return {};
  }

  Result<void> check_header() const {
    if (sequence_.frames.empty()) return bad("the header has no DimSize", "columns, rows and frames");
    if (!typed_) return bad("the header has no ElementType", "MET_UCHAR");
    // A guess could show a mirror image of the body.
    if (!orientation_) return unsupported("the header has no UltrasoundImageOrientation", kOrientations);
    const std::uint64_t there = file_bytes_ - header_bytes_;
    const std::uint64_t pixels = sequence_.frame_bytes() * sequence_.frames.size();
    if (!sequence_.compressed) {
      if (pixels <= there) return {};
      return bad(fmt::format("{} bytes of pixels follow the header", there), fmt::format("{}", pixels));
    }
    if (compressed_bytes_.value_or(0) > there) {
      return bad(fmt::format("{} bytes of compressed pixels follow the header", there),
                 fmt::format("the {} of its CompressedDataSize", *compressed_bytes_));
    }
    if (pixels / kMostInflation > compressed_bytes_.value_or(there)) {
      return bad(
          fmt::format("{} compressed bytes cannot hold its DimSize", compressed_bytes_.value_or(there)),
          fmt::format("what {} bytes of pixels take", pixels));
    }
    return {};
  }

  Result<void> allocate_pixels() {
    auto memory = allocate(sequence_.frame_bytes() * sequence_.frames.size());
    if (!memory) return memory.error();
    sequence_.pixels = *std::move(memory);
    return {};
  }

  Result<std::unique_ptr<std::uint8_t[]>> allocate(std::uint64_t bytes) const {
    std::unique_ptr<std::uint8_t[]> memory(new (std::nothrow) std::uint8_t[bytes]);
    if (memory == nullptr) {
      return bad(fmt::format("its pixels need {} bytes", bytes), "as much free memory",
                 ErrorCode::kUnavailable);
    }
    return memory;
  }

  Result<void> read_plain() {
    const std::uint64_t bytes = sequence_.frame_bytes() * sequence_.frames.size();
    const std::uint64_t there = std::fread(sequence_.pixels.get(), 1, bytes, file_.get());
    if (there != bytes)
      return bad(fmt::format("{} bytes of pixels can be read", there), fmt::format("{}", bytes));
    return {};
  }

  Result<void> read_compressed() {
    struct Inflation : z_stream {
      Inflation() : z_stream{} {}
      ~Inflation() { inflateEnd(this); }
      Inflation(const Inflation&) = delete;
      Inflation& operator=(const Inflation&) = delete;
    } stream;
    if (inflateInit(&stream) != Z_OK) {
      return bad("zlib cannot start", "free memory", ErrorCode::kUnavailable);
    }
    const std::uint64_t bytes = sequence_.frame_bytes() * sequence_.frames.size();
    std::uint64_t unread = compressed_bytes_.value_or(file_bytes_ - header_bytes_);
    std::uint64_t written = 0;
    std::vector<std::uint8_t> chunk(kChunkBytes);
    std::uint8_t beyond = 0;  // where a byte too many shows
    for (;;) {
      if (stream.avail_in == 0) {
        const std::size_t wanted = std::min<std::uint64_t>(unread, chunk.size());
        stream.avail_in = static_cast<uInt>(std::fread(chunk.data(), 1, wanted, file_.get()));
        stream.next_in = chunk.data();
        unread -= stream.avail_in;
      }
      const std::uint64_t room = bytes - written;
      const auto offered = static_cast<uInt>(room == 0 ? 1 : std::min<std::uint64_t>(room, 1U << 30));
      stream.next_out = room == 0 ? &beyond : sequence_.pixels.get() + written;
      stream.avail_out = offered;
      const int state = inflate(&stream, Z_NO_FLUSH);
      written += offered - stream.avail_out;
      if (written > bytes)
        return bad("its compressed pixels are more than its DimSize", fmt::format("{} bytes", bytes));
      if (state == Z_STREAM_END) break;
      // No input and no end: inflate then reports Z_BUF_ERROR.
      if (state != Z_OK) {
        return bad(fmt::format("its compressed pixels are damaged or cut off after {} bytes", written),
                   fmt::format("{} bytes", bytes));
      }
    }
    if (written == bytes) return {};
    return bad(fmt::format("its compressed pixels are {} bytes", written), fmt::format("{}", bytes));
  }

  /// From the order of the file to that of our frames, one frame after the other.
  Result<void> arrange_frames() {
    if (*orientation_ == ImageOrientation{}) return {};
    if (orientation_->lines_in_rows) {
      std::swap(sequence_.columns, sequence_.rows);
      if (sequence_.pixel_size) std::swap(sequence_.pixel_size->width_mm, sequence_.pixel_size->height_mm);
    }
    const std::uint64_t bytes = sequence_.frame_bytes();
    const auto image = allocate(bytes);
    if (!image) return image.error();
    for (std::size_t i = 0; i < sequence_.frames.size(); ++i) {
      const std::span frame(sequence_.pixels.get() + i * bytes, bytes);
      std::ranges::copy(frame, image->get());
      arrange_frame({image->get(), bytes}, *orientation_, {sequence_.columns, sequence_.rows}, frame);
    }
    return {};
  }

  static constexpr std::string_view kFramePrefix = "Seq_Frame";

  std::string name_;
  File file_;
  std::uint64_t file_bytes_;
  std::uint64_t max_bytes_;
  IgsSequence sequence_;
  std::string line_;
  std::uint64_t line_number_ = 0;
  std::uint64_t header_bytes_ = 0;
  std::optional<std::uint64_t> compressed_bytes_;
  bool typed_ = false;
  std::optional<ImageOrientation> orientation_;
};

}  // namespace

Result<IgsSequence> read_igs_sequence(const std::filesystem::path& path, std::uint64_t max_bytes) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status)) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{}: there is no such file, expected an .igs.mha sequence", shown(path))};
  }
  // Opening a pipe would wait for its other end.
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
  return SequenceReader(path, std::move(file), bytes, max_bytes).read();
}

}  // namespace fanlight
