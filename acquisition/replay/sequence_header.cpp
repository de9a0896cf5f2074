// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/sequence_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/replay/frame_fields.hpp"
#include "acquisition/replay/inflater.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kMostLines = 10'000;

/// A field that must have one value where it is present.
struct Requirement {
  std::string_view key;
  std::string_view value;
  std::string_view expected;
};
constexpr std::array kRequirements = {
    Requirement{"ObjectType", "Image", "Image"},
    Requirement{"BinaryData", "True", "True"},
    Requirement{"HeaderSize", "0", "0: pixels from the first byte of their file on"},
    Requirement{"ElementNumberOfChannels", "1", "1: grey pictures, such as the red channel alone"},
    Requirement{"UltrasoundImageType", "BRIGHTNESS",
                "BRIGHTNESS: pictures made of radio frequency lines, not the lines"},
};

struct ElementType {
  std::string_view name;
  PixelFormat format;
};
constexpr std::array kElementTypes = {
    ElementType{"MET_UCHAR", {}},
    ElementType{"MET_CHAR", {.is_signed = true}},
    ElementType{"MET_USHORT", {.bytes = 2}},
    ElementType{"MET_SHORT", {.bytes = 2, .is_signed = true}},
};

/// Reads the header of a MetaImage: lines "Name = value", the last one with the place of the pixels.
class MetaImageHeader {
 public:
  explicit MetaImageHeader(const NamedFile& from) : from_(from), lines_(from), fields_(from, header_) {}

  Result<SequenceHeader> read() {
    if (const auto done = read_lines(); !done) return done.error();
    if (!has_element_type_) return from_.bad("the header has no ElementType", "MET_UCHAR");
    if (const auto done = check_axes(); !done) return done.error();
    if (const auto done = header_.grid ? check(*header_.grid, from_.name) : fields_.check(); !done)
      return done.error();
    header_.header_bytes = lines_.bytes();
    return std::move(header_);
  }

 private:
  Result<void> read_lines() {
    for (;;) {
      const auto line = lines_.next();
      if (!line) return line.error();
      if (!*line) return from_.bad("the header ends too early", "a last line ElementDataFile = LOCAL");
      const std::string_view text = **line;
      const auto equals = text.find('=');
      if (equals == std::string_view::npos) {
        return from_.bad(fmt::format("line {} of the header is {}", lines_.number(), in_quotes(text)),
                         "Name = value");
      }
      const HeaderField field{trimmed(text.substr(0, equals)), trimmed(text.substr(equals + 1))};
      if (field.key == "ElementDataFile")
        return field.value == "LOCAL" ? Result<void>() : take_data_file(from_, field, header_);
      if (const auto done = take_field(field); !done) return done.error();
    }
  }

  Result<void> take_field(const HeaderField& field) {
    const auto& [key, value] = field;
    if (key.starts_with("Seq_Frame")) {
      const auto taken = fields_.take(field);
      return taken ? Result<void>() : taken.error();
    }
    // A second one that is equal says nothing new; another might describe other pixels than the first.
    if (key != "Comment") {
      const auto [first, is_new] = keys_.emplace(key, value);
      if (!is_new && first->second == value) return {};
      if (!is_new)
        return field.refused(from_, fmt::format("the same as before, {}", in_quotes(first->second)));
    }
    if (keys_.size() > kMostLines)
      return from_.bad(fmt::format("the header has over {} lines", kMostLines), "fewer");
    const auto* const required = std::ranges::find(kRequirements, key, &Requirement::key);
    if (required != kRequirements.end() && value != required->value)
      return field.refused(from_, required->expected, ErrorCode::kUnsupported);
    if (key == "ElementType") return take_element_type(field);
    if (key == "UltrasoundImageOrientation") return fields_.set_orientation(field);
    if (key == "NDims") {
      dimensions_ = number_in<std::uint32_t>(value).value_or(0);
      if (dimensions_ != 3 && dimensions_ != 4) {
        return field.refused(from_, "3: columns, rows and frames, or a volume; or 4: volumes",
                             ErrorCode::kUnsupported);
      }
    }
    if (key == "Kinds") has_time_axis_ = value.ends_with("list") || value.ends_with("time");
    if (key == "DistanceUnits" && value != "mm" && value != "?" && value != "none" && value != "unknown")
      return field.refused(from_, "mm", ErrorCode::kUnsupported);
    // ElementSize is what the spacing was called in old files.
    if (key == "ElementSpacing" || (key == "ElementSize" && spacing_mm_.empty())) take_spacing(value);
    // Three names for one thing, in the order of their age.
    if (key == "TransformMatrix" || key == "Rotation" || key == "Orientation") take_axes(value);
    if (key == "CompressedData") return take_flag(field, header_.sequence.compressed);
    // The second name is an older one.
    if (key == "BinaryDataByteOrderMSB" || key == "ElementByteOrderMSB")
      return take_flag(field, header_.format.big_endian);
    if (key == "CompressedDataSize") {
      header_.compressed_bytes = number_in<std::uint64_t>(value);
      if (!header_.compressed_bytes) return field.refused(from_, "a number of bytes");
    }
    if (key == "DimSize") return take_size(field);
    const auto taken = fields_.take(field);
    return taken ? Result<void>() : taken.error();
  }

  Result<void> take_flag(const HeaderField& field, bool& flag) const {
    if (field.value != "True" && field.value != "False") return field.refused(from_, "True or False");
    flag = field.value == "True";
    return {};
  }

  Result<void> take_element_type(const HeaderField& field) {
    const auto* const type = std::ranges::find(kElementTypes, field.value, &ElementType::name);
    if (type == kElementTypes.end()) {
      return field.refused(from_, "MET_UCHAR, MET_CHAR, MET_USHORT or MET_SHORT: 8 or 16 bit pixels",
                           ErrorCode::kUnsupported);
    }
    has_element_type_ = true;
    header_.format.bytes = type->format.bytes;
    header_.format.is_signed = type->format.is_signed;
    return {};
  }

  Result<void> take_size(const HeaderField& field) {
    std::vector<std::uint32_t> size(dimensions_);
    const auto rest = take_numbers<std::uint32_t>(field.value, std::span(size));
    if (!rest || !rest->empty()) size.assign(dimensions_, 0);
    size_ = size;
    volumes_ = dimensions_ == 4 ? size[3] : 1;
    return fields_.set_size(field, size[0], size[1], std::uint64_t{size[2]} * volumes_);
  }

  void take_spacing(std::string_view value) {
    spacing_mm_.assign(dimensions_, 0);
    const auto rest = take_numbers<double>(value, std::span(spacing_mm_));
    if (!rest || !rest->empty()) spacing_mm_.assign(dimensions_, 0);  // refused if this is a volume
  }

  /// The matrix's rows are the directions of the image's axes.
  void take_axes(std::string_view value) {
    std::vector<double> matrix(std::size_t{dimensions_} * dimensions_);
    const auto rest = take_numbers<double>(value, std::span(matrix));
    if (!rest || !rest->empty()) matrix.assign(matrix.size(), 0);  // refused if this is a volume
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < 3; ++i) axes_[axis][i] = matrix[axis * dimensions_ + i];
    }
  }

  /// A file without fields for frames, but with a spacing, is a volume; several, if it has four axes.
  Result<void> check_axes() {
    const bool is_volume = !fields_.describe_frames() && !size_.empty() && !spacing_mm_.empty();
    if (!is_volume) {
      if (!has_time_axis_.value_or(true)) {
        return from_.bad("its Kinds name no time axis, but it has fields for frames",
                         "Kinds = domain domain list, or a volume with a spacing and no frames",
                         ErrorCode::kUnsupported);
      }
      if (dimensions_ == 3) return {};
      return from_.bad("the image has 4 axes, and frames", "3 for frames; or volumes, with an ElementSpacing",
                       ErrorCode::kUnsupported);
    }
    const auto axes = orthogonal(axes_);
    if (!axes)
      return from_.bad("the axes of the volume are oblique", "a grid with right angles",
                       ErrorCode::kUnsupported);
    header_.grid = VoxelGrid{.size = {size_[0], size_[1], size_[2]},
                             .spacing_mm = {spacing_mm_[0], spacing_mm_[1], spacing_mm_[2]},
                             .is_left_handed = axes->is_left_handed,
                             .volumes = volumes_};
    // PLUS writes so of its reconstructed volumes.
    if (dimensions_ == 3 && has_time_axis_.value_or(false)) {
      header_.sequence.notes.emplace_back(
          "Its Kinds call the third axis a list, and it has no fields for frames: the axis is taken for "
          "elevation.");
    }
    return {};
  }

  const NamedFile& from_;
  HeaderLines lines_;
  SequenceHeader header_;
  FrameFields fields_;
  bool has_element_type_ = false;
  std::optional<bool> has_time_axis_;  // by Kinds
  std::uint32_t dimensions_ = 3;
  std::vector<std::uint32_t> size_;
  std::uint32_t volumes_ = 1;
  std::vector<double> spacing_mm_;
  std::array<std::array<double, 3>, 3> axes_ = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::map<std::string, std::string, std::less<>> keys_;  // of the lines that belong to no frame
};

}  // namespace

Result<void> take_data_file(const NamedFile& from, const HeaderField& field, SequenceHeader& header) {
  const std::string_view name = field.value;
  const bool is_name = !name.empty() && name.find('/') == std::string_view::npos &&
                       name.find('%') == std::string_view::npos && !name.starts_with("LIST") && name != "." &&
                       name != "..";
  if (!is_name) {
    return field.refused(from, "LOCAL (pixels in the same file), or the name of one file in the same folder",
                         ErrorCode::kUnsupported);
  }
  header.data_file = name;
  return {};
}

Result<SequenceHeader> read_meta_image_header(const NamedFile& from) {
  return MetaImageHeader(from).read();
}

Result<void> complete_frames(const NamedFile& from, SequenceHeader& header, std::uint64_t present,
                             std::uint64_t max_bytes) {
  FrameSequence& sequence = header.sequence;
  const std::uint64_t pixels = sequence.frame_bytes() * header.frames * header.format.bytes;
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
