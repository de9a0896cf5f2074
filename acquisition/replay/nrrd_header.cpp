// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/nrrd_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/replay/frame_fields.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kMostKeys = 10'000;
constexpr std::size_t kMostAxes = 4;

struct TypeName {
  std::string_view name;
  PixelFormat format;
};
constexpr PixelFormat kSigned8{.is_signed = true};
constexpr PixelFormat kUnsigned16{.bytes = 2};
constexpr PixelFormat kSigned16{.bytes = 2, .is_signed = true};
constexpr std::array kTypes = {
    TypeName{"unsigned char", {}},
    TypeName{"uchar", {}},
    TypeName{"uint8", {}},
    TypeName{"uint8_t", {}},
    TypeName{"signed char", kSigned8},
    TypeName{"int8", kSigned8},
    TypeName{"int8_t", kSigned8},
    TypeName{"unsigned short", kUnsigned16},
    TypeName{"ushort", kUnsigned16},
    TypeName{"unsigned short int", kUnsigned16},
    TypeName{"uint16", kUnsigned16},
    TypeName{"uint16_t", kUnsigned16},
    TypeName{"short", kSigned16},
    TypeName{"short int", kSigned16},
    TypeName{"signed short", kSigned16},
    TypeName{"signed short int", kSigned16},
    TypeName{"int16", kSigned16},
    TypeName{"int16_t", kSigned16},
};

class NrrdHeader {
 public:
  explicit NrrdHeader(const NamedFile& from) : from_(from), lines_(from), fields_(from, header_) {}

  Result<SequenceHeader> read() {
    if (const auto done = read_lines(); !done) return done.error();
    if (const auto done = check_axes(); !done) return done.error();
    if (const auto done = check_content(); !done) return done.error();
    if (!has_encoding_) return from_.bad("the header has no encoding", "raw or gzip");
    if (!has_endian_ && header_.format.bytes == 2)
      return from_.bad("the header has no endian, and its pixels are of 16 bit", "endian: little or big");
    header_.header_bytes = lines_.bytes();
    return std::move(header_);
  }

 private:
  Result<void> check_content() const {
    if (header_.grid) return check(*header_.grid, from_.name);
    return is_slicer_sequence_ ? Result<void>() : fields_.check();
  }

  Result<void> read_lines() {
    const auto magic = lines_.next();
    if (!magic) return magic.error();
    for (;;) {
      const auto line = lines_.next();
      if (!line) return line.error();
      if (!*line) {
        if (!header_.data_file.empty()) return {};  // a header alone
        return from_.bad("the header ends too early", "an empty line, and the pixels behind it");
      }
      const std::string_view text = trimmed(**line);
      if (text.empty()) return {};
      if (text.starts_with('#')) continue;
      if (auto taken = take_line(text); !taken) return taken;
    }
  }

  /// "field: value" of the format's own, or "key:=value".
  Result<void> take_line(std::string_view text) {
    const auto colon = text.find(':');
    if (colon == std::string_view::npos) {
      return from_.bad(fmt::format("line {} of the header is {}", lines_.number(), in_quotes(text)),
                       "field: value, or key:=value");
    }
    const bool pair = text.substr(colon).starts_with(":=");
    const HeaderField field{trimmed(text.substr(0, colon)), trimmed(text.substr(colon + (pair ? 2 : 1)))};
    if (pair && field.key.starts_with("Seq_Frame")) {
      const auto taken = fields_.take(field);
      return taken ? Result<void>() : taken.error();
    }
    const auto [first, is_new] = keys_.emplace(field.key, field.value);
    if (!is_new && first->second == field.value) return {};
    if (!is_new) return field.refused(from_, fmt::format("the same as before, {}", in_quotes(first->second)));
    if (keys_.size() > kMostKeys)
      return from_.bad(fmt::format("the header has over {} lines", kMostKeys), "fewer");
    return pair ? take_pair(field) : take_field(field);
  }

  Result<void> take_pair(const HeaderField& field) {
    const bool orientation =
        field.key == "ultrasound image orientation" || field.key == "UltrasoundImageOrientation";
    if (orientation) return fields_.set_orientation(field);
    if ((field.key == "ultrasound image type" || field.key == "UltrasoundImageType") &&
        field.value != "BRIGHTNESS") {
      return field.refused(from_, "BRIGHTNESS: pictures made of radio frequency lines, not the lines",
                           ErrorCode::kUnsupported);
    }
    if (field.key.starts_with("axis ") && field.key.ends_with(" index values"))
      take_index_values(field.value);
    const auto taken = fields_.take(field);
    return taken ? Result<void>() : taken.error();
  }

  /// 3D Slicer's times of the items of a list: "0 0.05 0.1". Texts are no times.
  void take_index_values(std::string_view text) {
    index_values_.clear();
    while (!text.empty() && index_values_.size() <= FrameFields::kMostFrames) {
      const auto word = text.substr(0, text.find(' '));
      const auto value = number_in<double>(word);
      if (!value || (!index_values_.empty() && *value < index_values_.back())) return index_values_.clear();
      index_values_.push_back(*value);
      text = trimmed(text.substr(word.size()));
    }
  }

  Result<void> take_field(const HeaderField& field) {
    const auto& [key, value] = field;
    if (key == "type") return take_type(field);
    if (key == "dimension") {
      dimension_ = number_in<std::uint32_t>(value).value_or(0);
      if (dimension_ < 3 || dimension_ > kMostAxes)
        return field.refused(from_, "3 or 4: columns, rows and frames", ErrorCode::kUnsupported);
    }
    if (key == "sizes") return take_sizes(field);
    if (key == "kinds") take_kinds(value);
    if (key == "spacings") spacings_ = values_of(value);
    if (key == "space origin") take_origin(value);
    if (key == "units" || key == "space units") return check_units(field);
    if (key == "space directions") take_directions(value);
    if (key == "space") space_ = value;
    if (key == "encoding") return take_encoding(field);
    if (key == "endian") {
      if (value != "little" && value != "big") return field.refused(from_, "little or big");
      has_endian_ = true;
      header_.format.big_endian = value == "big";
    }
    const bool skips = key == "byte skip" || key == "byteskip" || key == "line skip" || key == "lineskip";
    if (skips && value != "0") {
      return field.refused(from_,
                           "0: pixels directly behind the header, or from the first byte of their file",
                           ErrorCode::kUnsupported);
    }
    if (key == "data file" || key == "datafile") return take_data_file(from_, field, header_);
    return {};
  }

  Result<void> take_type(const HeaderField& field) {
    const auto* const type = std::ranges::find(kTypes, field.value, &TypeName::name);
    if (type == kTypes.end()) {
      return field.refused(from_, "uint8, int8, uint16 or int16: 8 or 16 bit pixels",
                           ErrorCode::kUnsupported);
    }
    has_type_ = true;
    header_.format.bytes = type->format.bytes;
    header_.format.is_signed = type->format.is_signed;
    return {};
  }

  Result<void> take_encoding(const HeaderField& field) {
    has_encoding_ = true;
    if (field.value == "raw") return {};
    if (field.value != "gzip" && field.value != "gz")
      return field.refused(from_, "raw or gzip", ErrorCode::kUnsupported);
    header_.sequence.compressed = header_.gzip = true;
    return {};
  }

  Result<void> take_sizes(const HeaderField& field) {
    std::string_view rest = field.value;
    while (!rest.empty() && sizes_.size() < kMostAxes) {
      std::array<std::uint32_t, 1> one{};
      const auto behind = take_numbers<std::uint32_t>(rest, one);
      if (!behind) break;
      sizes_.push_back(one[0]);
      rest = *behind;
    }
    if (!rest.empty() || sizes_.size() < 3)
      return field.refused(from_, "three or four numbers: columns, rows and frames");
    sizes_text_ = field.value;
    return {};
  }

  void take_kinds(std::string_view value) {
    while (!value.empty()) {
      const auto word = value.substr(0, value.find(' '));
      kinds_.emplace_back(word);
      value = trimmed(value.substr(word.size()));
    }
  }

  /// A number for each axis; 0 for "nan", which stands at one that is no length.
  static std::vector<double> values_of(std::string_view value) {
    std::vector<double> values;
    while (!value.empty() && values.size() < kMostAxes) {
      const auto word = value.substr(0, value.find(' '));
      values.push_back(number_in<double>(word).value_or(0));
      value = trimmed(value.substr(word.size()));
    }
    return values;
  }

  void use_spacings() {
    for (std::size_t axis = 0; axis < 3 && axis < spacings_.size(); ++axis) {
      axes_[axis] = {};
      axes_[axis][axis] = spacings_[axis];
      has_spacing_ = true;
    }
  }

  /// (x,y,z)
  void take_origin(std::string_view value) {
    std::string numbers(value.substr(0, value.find(')')));
    std::ranges::replace(numbers, ',', ' ');
    std::ranges::replace(numbers, '(', ' ');
    std::array<double, 3> origin{};
    if (take_numbers<double>(trimmed(numbers), std::span(origin))) origin_ = origin;
  }

  /// Lengths in mm and times in s, each in quotes; or nothing said.
  Result<void> check_units(const HeaderField& field) const {
    constexpr std::string_view kKnown[] = {"", "mm", "s", "sec", "?"};
    std::string_view rest = field.value;
    for (std::size_t begin = rest.find('"'); begin != std::string_view::npos; begin = rest.find('"')) {
      const std::string_view unit = rest.substr(begin + 1, rest.find('"', begin + 1) - begin - 1);
      if (std::ranges::find(kKnown, unit) == std::end(kKnown))
        return field.refused(from_, "lengths in \"mm\" and times in \"s\"", ErrorCode::kUnsupported);
      const std::size_t end = rest.find('"', begin + 1);
      if (end == std::string_view::npos) break;
      rest = rest.substr(end + 1);
    }
    return {};
  }

  /// A vector (x,y,z) for each axis in space; "none" for a list.
  void take_directions(std::string_view value) {
    constexpr std::string_view kNone = "none";
    for (std::size_t axis = 0; axis < 3 && !value.empty();) {
      if (value.starts_with(kNone)) {
        value = trimmed(value.substr(kNone.size()));
        continue;
      }
      const auto word = trimmed(value.substr(0, value.find(')') + 1));
      axes_[axis] = {};
      if (!value.starts_with('(') || word.empty()) return;  // refused if this is a volume
      std::string numbers(word.substr(1, word.size() - 2));
      std::ranges::replace(numbers, ',', ' ');
      if (!take_numbers<double>(trimmed(numbers), axes_[axis])) axes_[axis] = {};
      ++axis;
      value = trimmed(value.substr(word.size()));
      has_spacing_ = true;
    }
  }

  /// A file without fields for frames, but with a spacing, is a volume; several, if the last of four
  /// axes is a list.
  bool is_volume() const {
    if (fields_.describe_frames() || !has_spacing_) return false;
    const bool are_several = sizes_.size() == 4;
    if (kinds_.empty()) return true;
    return are_several ? is_list(kinds_.back()) : !is_list(kinds_.back());
  }

  Result<void> take_grid(const HeaderField& field) {
    const auto axes = orthogonal(axes_);
    if (!axes) {
      return from_.bad("the axes of the volume are oblique, or have no length", "a grid with right angles",
                       ErrorCode::kUnsupported);
    }
    const bool left_space = space_ == "left-anterior-superior" || space_ == "LAS" ||
                            space_ == "left-anterior-superior-time" || space_ == "LAST" ||
                            space_.starts_with("3D-left-handed");
    const std::uint32_t volumes = sizes_.size() == 4 ? sizes_[3] : 1;
    if (volumes > 1 && sizes_[2] == 1) return take_slicer_frames(field, axes->lengths);
    header_.grid = VoxelGrid{.size = {sizes_[0], sizes_[1], sizes_[2]},
                             .spacing_mm = axes->lengths,
                             .is_left_handed = axes->is_left_handed != left_space,
                             .volumes = volumes};
    if (index_values_.size() == volumes && volumes > 1) header_.grid->volume_times_s = index_values_;
    // Of our own: its axes are the transducer's, written as left, posterior and superior.
    if (header_.sequence.fanlight_fields.contains("FanlightAxes") && !header_.grid->is_left_handed)
      header_.grid->origin_mm = origin_;
    return fields_.set_size(field, sizes_[0], sizes_[1], std::uint64_t{sizes_[2]} * volumes);
  }

  /// A sequence of single planes, as 3D Slicer saves one: it has a spacing, times, and no orientation.
  Result<void> take_slicer_frames(const HeaderField& field, const std::array<double, 3>& spacing_mm) {
    if (auto sized = fields_.set_size(field, sizes_[0], sizes_[1], sizes_[3]); !sized) return sized;
    for (const double each : {spacing_mm[0], spacing_mm[1]}) {
      if (!(each >= 0.001 && each <= 10))
        return from_.bad(fmt::format("its pixels have {} mm", each), "0.001 to 10 mm");
    }
    is_slicer_sequence_ = true;
    FrameSequence& sequence = header_.sequence;
    sequence.pixel_size = {.width_mm = spacing_mm[0], .height_mm = spacing_mm[1]};
    sequence.pixel_size_origin = "its spacing";
    sequence.notes.emplace_back(
        "The frames have no orientation: columns are taken to ascend towards the marked side, rows away from "
        "the "
        "probe.");
    if (index_values_.size() != sizes_[3]) return {};
    sequence.frames.resize(sizes_[3]);
    for (std::size_t i = 0; i < sequence.frames.size(); ++i)
      sequence.frames[i].timestamp_s = index_values_[i];
    return {};
  }

  /// The list comes first: the pixels of all frames are interleaved.
  void put_list_last() {
    header_.frames_first = true;
    std::rotate(sizes_.begin(), sizes_.begin() + 1, sizes_.end());
    std::rotate(kinds_.begin(), kinds_.begin() + 1, kinds_.end());
    if (spacings_.size() == sizes_.size())
      std::rotate(spacings_.begin(), spacings_.begin() + 1, spacings_.end());
  }

  static bool is_list(const std::string& kind) { return kind == "list" || kind == "time"; }

  Result<void> check_axes() {
    if (!has_type_) return from_.bad("the header has no type", "uint8, int8, uint16 or int16");
    if (sizes_.empty()) return from_.bad("the header has no sizes", "columns, rows and frames");
    const HeaderField field{"sizes", sizes_text_};
    if (sizes_.size() != dimension_)
      return field.refused(from_, fmt::format("as many numbers as its dimension {}", dimension_));
    if (!kinds_.empty() && kinds_.size() != sizes_.size())
      return from_.bad(fmt::format("the header has {} kinds", kinds_.size()), "one for each axis");
    if (!kinds_.empty() && is_list(kinds_.front()) && !is_list(kinds_.back())) put_list_last();
    use_spacings();
    if (is_volume()) return take_grid(field);
    // Without kinds the last axis is taken for time, as PLUS does.
    if (!kinds_.empty() && !is_list(kinds_.back())) {
      return from_.bad("no axis is a list of frames, and a volume on a grid needs a spacing",
                       "kinds: domain domain list, with a frame behind the other; or space directions",
                       ErrorCode::kUnsupported);
    }
    // A frame may be a volume of one plane.
    if (sizes_.size() == 4 && sizes_[2] != 1) {
      return field.refused(from_, "one plane a frame: columns, rows, 1, frames", ErrorCode::kUnsupported);
    }
    return fields_.set_size(field, sizes_[0], sizes_[1], sizes_.back());
  }

  const NamedFile& from_;
  HeaderLines lines_;
  SequenceHeader header_;
  FrameFields fields_;
  std::uint32_t dimension_ = 0;
  std::vector<std::uint32_t> sizes_;
  std::string sizes_text_;
  std::vector<std::string> kinds_;
  std::array<std::array<double, 3>, 3> axes_{};
  bool has_spacing_ = false;
  bool is_slicer_sequence_ = false;
  std::vector<double> index_values_;
  std::vector<double> spacings_;
  std::optional<std::array<double, 3>> origin_;
  std::string space_;
  bool has_type_ = false;
  bool has_encoding_ = false;
  bool has_endian_ = false;
  std::map<std::string, std::string, std::less<>> keys_;
};

}  // namespace

Result<SequenceHeader> read_nrrd_header(const NamedFile& from) {
  return NrrdHeader(from).read();
}

}  // namespace fanlight
