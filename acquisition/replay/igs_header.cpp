// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/igs_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "acquisition/record/plus_fields.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kLongestLine = 65'536;
constexpr std::uint32_t kMostSide = 4096;
constexpr std::uint32_t kMostFrames = 1'000'000;
constexpr std::uint32_t kMostFramesUndescribed = 100;  // between two that are
constexpr std::size_t kMostKeys = 10'000;
constexpr std::size_t kMostFanlightFields = 64;
// Best ratio of Deflate: one byte of input yields at most this many bytes of output.
constexpr std::uint64_t kMostInflation = 1032;
constexpr std::string_view kOrientations = "MF, MN, UF, UN, FM, FU, NM or NU, with or without A or D behind";
constexpr std::string_view kFramePrefix = "Seq_Frame";

/// A field that must have one value where it is present.
struct Requirement {
  std::string_view key;
  std::string_view value;
  std::string_view expected;
};
constexpr std::array kRequirements = {
    Requirement{"ObjectType", "Image", "Image"},
    Requirement{"NDims", "3", "3 (columns, rows, frames): colour and 4D images are not taken"},
    Requirement{"BinaryData", "True", "True"},
    Requirement{"HeaderSize", "0", "0: pixels from the first byte of their file on"},
    Requirement{"ElementNumberOfChannels", "1", "1: grey pictures, such as the red channel alone"},
    Requirement{"ElementType", "MET_UCHAR", "MET_UCHAR: 8 bit pixels, scaled from the others by a window"},
    Requirement{"UltrasoundImageType", "BRIGHTNESS",
                "BRIGHTNESS: pictures made of radio frequency lines, not the lines"},
};

struct Line {
  std::string_view key;
  std::string_view value;
};

/// A field of one frame: Seq_Frame0000_Name.
struct FrameField {
  IgsFrame& frame;
  std::uint32_t index;
  std::string_view name;
};

class HeaderReader {
 public:
  explicit HeaderReader(const IgsFile& from) : from_(from) {}

  Result<IgsHeader> read() {
    if (const auto done = read_lines(); !done) return done.error();
    if (const auto done = check_presence(); !done) return done.error();
    header_.orientation = *orientation_;
    return std::move(header_);
  }

 private:
  Error bad(std::string_view wrong, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const {
    return from_.bad(wrong, expected, code);
  }
  Error refused(const Line& line, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const {
    return bad(fmt::format("{} is {}", in_quotes(line.key), in_quotes(line.value)), expected, code);
  }

  Result<void> read_lines() {
    for (;;) {
      const auto line = next_line();
      if (!line) return line.error();
      if (line->key == "ElementDataFile") {
        return take_data_file(*line);
      }
      const auto taken = line->key.starts_with(kFramePrefix) ? take_frame_field(*line) : take_field(*line);
      if (!taken) return taken.error();
    }
  }

  /// Nothing outside of the header's own folder is opened.
  Result<void> take_data_file(const Line& line) {
    if (line.value == "LOCAL") return {};
    const bool is_name = !line.value.empty() && line.value.find('/') == std::string_view::npos &&
                         line.value.find('%') == std::string_view::npos && line.value != "LIST" &&
                         line.value != "." && line.value != "..";
    if (!is_name) {
      return refused(line, "LOCAL (pixels in the same file), or the name of one file in the same folder",
                     ErrorCode::kUnsupported);
    }
    header_.data_file = line.value;
    return {};
  }

  /// The next line; valid until the next call.
  Result<Line> next_line() {
    ++line_number_;
    line_.clear();
    for (;;) {
      const int c = std::getc(from_.file);
      if (c == EOF) return bad("the header ends too early", "a last line ElementDataFile = LOCAL");
      ++header_.header_bytes;
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
    // The second one might describe other pixels than the first.
    if (key != "Comment" && !keys_.emplace(key).second) return refused(line, "each line of the header once");
    if (keys_.size() > kMostKeys) return bad(fmt::format("the header has over {} lines", kMostKeys), "fewer");
    const auto* const required = std::ranges::find(kRequirements, key, &Requirement::key);
    if (required != kRequirements.end() && value != required->value) {
      return refused(line, required->expected, ErrorCode::kUnsupported);
    }
    if (key == "ElementType") has_element_type_ = true;
    if (key == "UltrasoundImageOrientation") {
      orientation_ = ImageOrientation::from_letters(value);
      if (!orientation_) return refused(line, kOrientations, ErrorCode::kUnsupported);
    }
    if (key == "Kinds" && !value.ends_with("list") && !value.ends_with("time")) {
      return refused(line, "domain domain list: frames of a sweep, not a volume on a grid",
                     ErrorCode::kUnsupported);
    }
    if (key == "CompressedData") {
      if (value != "True" && value != "False") return refused(line, "True or False");
      header_.sequence.compressed = value == "True";
    }
    if (key == "CompressedDataSize") {
      header_.compressed_bytes = number_in<std::uint64_t>(value);
      if (!header_.compressed_bytes) return refused(line, "a number of bytes");
    }
    if (key == "DimSize") return take_size(line);
    if (key.starts_with("Fanlight")) return take_fanlight_field(line);
    return {};
  }

  Result<void> take_fanlight_field(const Line& line) {
    auto& fields = header_.sequence.fanlight_fields;
    if (fields.size() == kMostFanlightFields) {
      return bad(fmt::format("the header has more than {} Fanlight fields", kMostFanlightFields), "fewer");
    }
    fields.emplace(line.key, line.value);
    return {};
  }

  Result<void> take_size(const Line& line) {
    constexpr std::string_view kExpected =
        "three numbers: columns and rows from 2 to 4096, frames from 1 to 1000000";
    std::array<std::uint32_t, 3> size{};
    const auto rest = take_numbers<std::uint32_t>(line.value, size);
    if (!rest) return refused(line, kExpected);
    const auto [columns, rows, frames] = size;
    const bool fits = columns >= 2 && columns <= kMostSide && rows >= 2 && rows <= kMostSide && frames >= 1 &&
                      frames <= kMostFrames;
    if (!rest->empty() || !fits) return refused(line, kExpected);
    if (header_.sequence.frames.size() > frames) {
      return refused(line, fmt::format("the {} frames that the lines before it describe",
                                       header_.sequence.frames.size()));
    }
    has_size_ = true;
    header_.sequence.columns = columns;
    header_.sequence.rows = rows;
    header_.frames = frames;
    return {};
  }

  /// Numbers at the front of `text`, separated by blanks; returns the text behind them, or nullopt.
  template <typename T>
  static std::optional<std::string_view> take_numbers(std::string_view text, std::span<T> numbers) {
    for (T& each : numbers) {
      const auto word = text.substr(0, text.find(' '));
      const auto number = number_in<T>(word);
      if (!number) return std::nullopt;
      each = *number;
      text = trimmed(text.substr(word.size()));
    }
    return text;
  }

  Result<FrameField> frame_field(const Line& line) {
    auto& frames = header_.sequence.frames;
    const std::string_view numbered = line.key.substr(kFramePrefix.size());
    const auto underscore = numbered.find('_');
    const auto index = number_in<std::uint32_t>(numbered.substr(0, underscore));
    if (underscore == std::string_view::npos || !index) {
      return bad(fmt::format("the header has a field {}", in_quotes(line.key)), "Seq_Frame0000_Name");
    }
    // Older files of PLUS give the DimSize after the frames.
    if (*index >= (has_size_ ? header_.frames : kMostFrames)) {
      return bad(fmt::format("the header describes frame {}", *index),
                 fmt::format("the {} frames of its DimSize, from 0", header_.frames));
    }
    // The list grows with the lines, so that a short header takes little memory.
    if (*index > frames.size() + kMostFramesUndescribed) {
      return bad(fmt::format("the header describes frame {} after frame {}", *index, frames.size()),
                 "the frames in their order");
    }
    if (*index >= frames.size()) frames.resize(*index + 1);
    return FrameField{frames[*index], *index, numbered.substr(underscore + 1)};
  }

  Result<void> take_frame_field(const Line& line) {
    const auto field = frame_field(line);
    if (!field) return field.error();
    const auto& [frame, index, name] = *field;
    // The lines of a frame stand together.
    if (std::exchange(last_frame_, index) != index) keys_of_frame_.clear();
    if (!keys_of_frame_.emplace(name).second) return refused(line, "each line of a frame once");
    if (name == "Timestamp") return take_number(line, frame.timestamp_s, "seconds");
    if (name == "MotorAngleDeg") return take_number(line, frame.motor_angle_deg, "degrees");
    if (name == "VolumeIndex") return take_number(line, frame.volume_index, "a whole number from 0");
    if (name == "FrameIndex") return take_number(line, frame.frame_index, "a whole number from 0");
    if (name == plus_field::kMotorAngleRad) return take_number(line, frame.motor_angle_rad, "radians");
    if (name == plus_field::kFrameSequence) return take_number(line, frame.sequence, "a whole number from 0");
    if (name == plus_field::kFramesInSweep)
      return take_number(line, frame.frames_in_sweep, "a whole number from 0");
    if (name == plus_field::kAfterInterruption) frame.after_interruption = line.value == "1";
    if (name == plus_field::kFrameFault) {
      const auto fault = fault_named(line.value);
      if (!fault) return refused(line, "invalid, damaged, cut or misfit");
      frame.fault = *fault;
    }
    if (name.ends_with("Transform") && (name.starts_with("Image") || name.starts_with("Probe")))
      return take_transform(line, name);
    if (name == "ImageStatus") {
      if (line.value != "OK" && line.value != "INVALID") return refused(line, "OK or INVALID");
      frame.valid = line.value == "OK";
    }
    if (name == "SweepDirection") {
      if (line.value != "FORWARD" && line.value != "BACKWARD") return refused(line, "FORWARD or BACKWARD");
      frame.direction = line.value == "FORWARD" ? SweepDirection::kForward : SweepDirection::kBackward;
    }
    return {};
  }

  template <typename T>
  Result<void> take_number(const Line& line, std::optional<T>& number, std::string_view expected) const {
    if (number) return refused(line, "each line of a frame once");
    number = number_in<T>(line.value);
    if (!number) return refused(line, expected);
    return {};
  }

  /// The pixel size is the lengths of the matrix's first two columns: mm along the image's x and y axes.
  Result<void> take_transform(const Line& line, std::string_view name) {
    std::array<double, 16> matrix{};  // row order
    IgsSequence& sequence = header_.sequence;
    const bool sets_pixel_size = name == "ImageToReferenceTransform" && !sequence.pixel_size;
    if (!take_numbers<double>(line.value, matrix)) {
      if (sets_pixel_size) return refused(line, "a matrix of 16 numbers");
      return {};
    }
    // PLUS writes the identity where the tracker saw nothing.
    constexpr std::array<double, 16> kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (matrix == kIdentity) return {};
    if (sets_pixel_size) {
      sequence.pixel_size = {.width_mm = std::hypot(matrix[0], matrix[4], matrix[8]),
                             .height_mm = std::hypot(matrix[1], matrix[5], matrix[9])};
    }
    constexpr std::size_t kMostTransforms = 16;
    auto motion = sequence.motions.find(name);
    if (motion == sequence.motions.end()) {
      if (sequence.motions.size() < kMostTransforms)
        sequence.motions.emplace(name, IgsSequence::Motion{matrix});
      return {};
    }
    add_motion(motion->second, matrix);
    return {};
  }

  /// The turn from one matrix to another by the trace of their product; the columns may have any length.
  static void add_motion(IgsSequence::Motion& motion, const std::array<double, 16>& matrix) {
    const std::array<double, 16>& first = motion.first;
    motion.most_mm = std::max(motion.most_mm,
                              std::hypot(matrix[3] - first[3], matrix[7] - first[7], matrix[11] - first[11]));
    double trace = 0;
    for (std::size_t column = 0; column < 3; ++column) {
      double product = 0;
      double first_length = 0;
      double length = 0;
      for (std::size_t row = 0; row < 3; ++row) {
        const double a = first[4 * row + column];
        const double b = matrix[4 * row + column];
        product += a * b;
        first_length += a * a;
        length += b * b;
      }
      const double lengths = std::sqrt(first_length * length);
      trace += lengths > 0 ? product / lengths : 1;
    }
    const double turn_deg = degrees(std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0)));
    motion.most_deg = std::max(motion.most_deg, turn_deg);
  }

  Result<void> check_presence() const {
    if (!has_size_) return bad("the header has no DimSize", "columns, rows and frames");
    if (!has_element_type_) return bad("the header has no ElementType", "MET_UCHAR");
    if (!last_frame_) {
      return bad("this is a picture or a volume on a grid: it describes no frames of a sweep",
                 "lines such as Seq_Frame0000_Timestamp for each frame, as PLUS writes them",
                 ErrorCode::kUnsupported);
    }
    if (orientation_) return {};
    // Not guessed: a wrong orientation shows a mirror image of the body.
    return bad("the header has no UltrasoundImageOrientation", kOrientations, ErrorCode::kUnsupported);
  }

  const IgsFile& from_;
  IgsHeader header_;
  std::string line_;
  std::uint64_t line_number_ = 0;
  bool has_size_ = false;
  bool has_element_type_ = false;
  std::set<std::string, std::less<>> keys_;           // of the lines that belong to no frame
  std::set<std::string, std::less<>> keys_of_frame_;  // of the frame that was described last
  std::optional<std::uint32_t> last_frame_;
  std::optional<ImageOrientation> orientation_;
};

}  // namespace

Error IgsFile::bad(std::string_view wrong, std::string_view expected, ErrorCode code) const {
  return {code, fmt::format("{}: {}, expected {}", name, wrong, expected)};
}

Result<IgsHeader> read_igs_header(const IgsFile& from) {
  return HeaderReader(from).read();
}

Result<void> complete_frames(const IgsFile& from, IgsHeader& header, std::uint64_t present,
                             std::uint64_t max_bytes) {
  IgsSequence& sequence = header.sequence;
  const std::uint64_t pixels = sequence.frame_bytes() * header.frames;
  if (pixels > max_bytes) {
    return from.bad(fmt::format("its DimSize is {} bytes of pixels", pixels),
                    fmt::format("at most {} bytes of pixels", max_bytes));
  }
  if (!sequence.compressed && pixels > present)
    return from.bad(fmt::format("{} bytes of pixels follow the header", present), fmt::format("{}", pixels));
  if (sequence.compressed && header.compressed_bytes.value_or(0) > present) {
    return from.bad(fmt::format("{} bytes of compressed pixels follow the header", present),
                    fmt::format("the {} of its CompressedDataSize", *header.compressed_bytes));
  }
  const std::uint64_t stored = sequence.compressed ? header.compressed_bytes.value_or(present) : present;
  if (pixels / kMostInflation > stored) {
    return from.bad(fmt::format("{} compressed bytes cannot hold its DimSize", stored),
                    fmt::format("what {} bytes of pixels take", pixels));
  }
  sequence.frames.resize(header.frames);
  return {};
}

}  // namespace fanlight
