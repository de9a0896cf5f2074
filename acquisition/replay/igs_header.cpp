// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/igs_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <utility>

#include "acquisition/replay/frame_fields.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kMostKeys = 10'000;
// Best ratio of Deflate: one byte of input yields at most this many bytes of output.
constexpr std::uint64_t kMostInflation = 1032;

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
  explicit MetaImageHeader(const IgsFile& from) : from_(from), lines_(from), fields_(from, header_) {}

  Result<IgsHeader> read() {
    if (const auto done = read_lines(); !done) return done.error();
    if (!has_element_type_) return from_.bad("the header has no ElementType", "MET_UCHAR");
    if (const auto done = fields_.check(); !done) return done.error();
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
    // The second one might describe other pixels than the first.
    if (key != "Comment" && !keys_.emplace(key).second)
      return field.refused(from_, "each line of the header once");
    if (keys_.size() > kMostKeys)
      return from_.bad(fmt::format("the header has over {} lines", kMostKeys), "fewer");
    const auto* const required = std::ranges::find(kRequirements, key, &Requirement::key);
    if (required != kRequirements.end() && value != required->value)
      return field.refused(from_, required->expected, ErrorCode::kUnsupported);
    if (key == "ElementType") return take_element_type(field);
    if (key == "UltrasoundImageOrientation") return fields_.set_orientation(field);
    if (key == "Kinds" && !value.ends_with("list") && !value.ends_with("time")) {
      return field.refused(from_, "domain domain list: frames of a sweep, not a volume on a grid",
                           ErrorCode::kUnsupported);
    }
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
    std::array<std::uint32_t, 3> size{};
    const auto rest = take_numbers<std::uint32_t>(field.value, size);
    if (!rest || !rest->empty()) size = {};
    return fields_.set_size(field, size[0], size[1], size[2]);
  }

  const IgsFile& from_;
  HeaderLines lines_;
  IgsHeader header_;
  FrameFields fields_;
  bool has_element_type_ = false;
  std::set<std::string, std::less<>> keys_;  // of the lines that belong to no frame
};

}  // namespace

Result<void> take_data_file(const IgsFile& from, const HeaderField& field, IgsHeader& header) {
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

Result<IgsHeader> read_igs_header(const IgsFile& from) {
  return MetaImageHeader(from).read();
}

Result<void> complete_frames(const IgsFile& from, IgsHeader& header, std::uint64_t present,
                             std::uint64_t max_bytes) {
  IgsSequence& sequence = header.sequence;
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
