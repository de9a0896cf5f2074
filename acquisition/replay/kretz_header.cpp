// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/kretz_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "acquisition/replay/frame_fields.hpp"
#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

static_assert(std::endian::native == std::endian::little, "the file's numbers are read as they are");

constexpr std::string_view kMagic = "KRETZFILE 1.0   ";
constexpr std::uint32_t kMostItems = 10'000;

/// Group and element of an item.
constexpr std::uint32_t tag(std::uint32_t group, std::uint32_t element) {
  return group << 16 | element;
}
constexpr std::uint32_t kSamples = tag(0xC000, 1);
constexpr std::uint32_t kLines = tag(0xC000, 2);
constexpr std::uint32_t kFrames = tag(0xC000, 3);
constexpr std::uint32_t kRadialStep = tag(0xC100, 1);  // metres
constexpr std::uint32_t kOffset1 = tag(0xC200, 1);     // samples
constexpr std::uint32_t kOffset2 = tag(0xC200, 2);
constexpr std::uint32_t kSweepAngles = tag(0xC300, 1);  // radians
constexpr std::uint32_t kLineAngles = tag(0xC300, 2);
constexpr std::uint32_t kVoxels = tag(0xD000, 1);
constexpr std::uint32_t kCineFrames = tag(0xD400, 1);
constexpr std::uint32_t kCineData = tag(0xD600, 1);

class KretzHeader {
 public:
  explicit KretzHeader(const NamedFile& from) : from_(from), fields_(from, header_) {}

  Result<SequenceHeader> read() {
    if (const auto done = read_items(); !done) return done.error();
    if (const auto done = check_items(); !done) return done.error();
    if (const auto done = take_size(); !done) return done.error();
    if (const auto done = take_geometry(); !done) return done.error();
    return std::move(header_);
  }

 private:
  Error bad(std::string_view wrong, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const {
    return from_.bad(wrong, expected, code);
  }
  Error unsupported(std::string_view wrong) const {
    return bad(wrong, "one B-mode volume of a swept probe, not compressed", ErrorCode::kUnsupported);
  }

  bool read_bytes(void* to, std::size_t bytes) {
    at_ += bytes;
    return std::fread(to, 1, bytes, from_.file) == bytes;
  }

  Result<void> read_items() {
    std::array<char, kMagic.size()> magic{};
    if (!read_bytes(magic.data(), magic.size()) || std::string_view(magic.data(), magic.size()) != kMagic)
      return unsupported("this is a Kretz file of another version");
    for (std::uint32_t item = 0; at_ < from_.bytes; ++item) {
      std::uint16_t group = 0;
      std::uint16_t element = 0;
      std::uint32_t length = 0;
      const bool whole = read_bytes(&group, sizeof group) && read_bytes(&element, sizeof element) &&
                         read_bytes(&length, sizeof length);
      if (!whole || length > from_.bytes - at_ || item == kMostItems) {
        return bad(fmt::format("item {} of the file is cut off", item), "as many bytes as its length says");
      }
      if (auto taken = take_item(tag(group, element), length); !taken) return taken;
    }
    return {};
  }

  Result<void> take_item(std::uint32_t what, std::uint32_t length) {
    if (what == kCineFrames || what == kCineData) several_ = true;
    if (what == kVoxels) {
      voxels_at_ = at_;
      voxels_ = length;
    }
    const bool size = what == kSamples || what == kLines || what == kFrames;
    const bool number = what == kRadialStep || what == kOffset1 || what == kOffset2;
    if (size) return take_number<std::uint16_t>(what, length);
    if (number) return take_number<double>(what, length);
    if (what == kSweepAngles) return take_table(sweep_rad_, length);
    if (what == kLineAngles) return take_table(line_rad_, length);
    return skip(length);
  }

  Result<void> skip(std::uint32_t length) {
    at_ += length;
    if (std::fseek(from_.file, static_cast<long>(at_), SEEK_SET) == 0) return {};
    return bad("the file cannot be read on", "a file that can");
  }

  template <typename T>
  Result<void> take_number(std::uint32_t what, std::uint32_t length) {
    T value{};
    if (length != sizeof value || !read_bytes(&value, sizeof value))
      return bad(fmt::format("item {:04X}/{:04X} has {} bytes", what >> 16, what & 0xFFFF, length),
                 fmt::format("{}", sizeof value));
    if (std::ranges::find(numbers_, what, &Number::what) == numbers_.end())
      numbers_.push_back({what, static_cast<double>(value)});
    return {};
  }

  Result<void> take_table(std::vector<double>& table, std::uint32_t length) {
    if (length % sizeof(double) != 0 || length > FrameFields::kMostSide * sizeof(double))
      return bad(fmt::format("a table of angles has {} bytes", length), "8 for each line or frame");
    table.resize(length / sizeof(double));
    if (!read_bytes(table.data(), length)) return bad("a table of angles is cut off", "all of it");
    return {};
  }

  std::optional<double> number(std::uint32_t what) const {
    const auto found = std::ranges::find(numbers_, what, &Number::what);
    return found == numbers_.end() ? std::nullopt : std::optional(found->value);
  }

  Result<void> check_items() {
    if (voxels_ == 0) {
      return unsupported(several_ ? "this Kretz file has several volumes (4D), or compressed ones"
                                  : "this Kretz file has no plain voxels: they are compressed");
    }
    if (sweep_rad_.empty() || line_rad_.empty())
      return unsupported("this Kretz file has no angles: its volume is a Cartesian one");
    for (const std::uint32_t what : {kSamples, kLines, kFrames, kRadialStep, kOffset1, kOffset2}) {
      if (!number(what))
        return bad(fmt::format("item {:04X}/{:04X} is missing", what >> 16, what & 0xFFFF), "its number");
    }
    return {};
  }

  Result<void> take_size() {
    const auto samples = static_cast<std::uint64_t>(*number(kSamples));
    const auto lines = static_cast<std::uint64_t>(*number(kLines));
    const auto frames = static_cast<std::uint64_t>(*number(kFrames));
    const std::string text = fmt::format("{} {} {}", samples, lines, frames);
    if (auto done = fields_.set_size({"size", text}, samples, lines, frames); !done) return done;
    if (auto done = fields_.set_orientation({"orientation", "FM"}); !done) return done;
    if (samples * lines * frames != voxels_) {
      return unsupported(fmt::format("{} bytes of voxels stand for {} x {} x {}: they are compressed",
                                     voxels_, samples, lines, frames));
    }
    if (line_rad_.size() != lines || sweep_rad_.size() != frames) {
      return bad(
          fmt::format("there are {} angles of lines and {} of frames", line_rad_.size(), sweep_rad_.size()),
          fmt::format("{} and {}", lines, frames));
    }
    header_.header_bytes = voxels_at_;
    return {};
  }

  Result<void> take_geometry() {
    const double step_mm = 1000 * *number(kRadialStep);
    const double probe_radius_mm = *number(kOffset1) * step_mm;
    const double axis_mm = -*number(kOffset2) * step_mm;
    const auto last = static_cast<double>(line_rad_.size() - 1);
    const double pitch_rad = (line_rad_.back() - line_rad_.front()) / last;
    for (std::size_t line = 0; line < line_rad_.size(); ++line) {
      const double off_rad = line_rad_[line] - line_rad_.front() - pitch_rad * static_cast<double>(line);
      // A tenth of the pitch moves an echo by less than a sample.
      if (!(std::abs(off_rad) <= 0.1 * std::abs(pitch_rad)))
        return unsupported(fmt::format("line {} is off an even spread of the lines", line));
    }
    const auto field = [this](std::string_view name, const auto& value) {
      header_.sequence.fanlight_fields.emplace(name, fmt::format("{}", value));
    };
    field("FanlightFrameKind", kFrameKindNames[static_cast<std::size_t>(FrameKind::kConvexLines)]);
    field("FanlightPixelHeightMm", step_mm);
    field("FanlightLinePitchDeg", degrees(std::abs(pitch_rad)));
    field("FanlightFaceColumn", last / 2);
    field("FanlightFaceRow", 0);
    field("FanlightProbeRadiusMm", probe_radius_mm);
    field("FanlightMotorRadiusMm", probe_radius_mm - axis_mm);
    header_.orientation.towards_unmarked = pitch_rad < 0;
    return take_frames();
  }

  /// The readers of this format differ in where they put angle 0; the middle of the sweep is in the middle.
  Result<void> take_frames() {
    const double middle_rad = (sweep_rad_.front() + sweep_rad_.back()) / 2;
    auto& frames = header_.sequence.frames;
    frames.resize(sweep_rad_.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const double angle_rad = sweep_rad_[i] - middle_rad;
      if (!std::isfinite(angle_rad))
        return bad(fmt::format("the angle of frame {} is no number", i), "radians");
      frames[i].motor_angle_deg = degrees(angle_rad);
      frames[i].timestamp_s = kAssumedFrameS * static_cast<double>(i);
      frames[i].volume_index = 0;
      frames[i].frame_index = static_cast<std::uint32_t>(i);
    }
    return {};
  }

  struct Number {
    std::uint32_t what;
    double value;
  };

  const NamedFile& from_;
  SequenceHeader header_;
  FrameFields fields_;
  std::uint64_t at_ = 0;  // offset in the file
  std::uint64_t voxels_at_ = 0;
  std::uint64_t voxels_ = 0;  // bytes
  bool several_ = false;
  std::vector<Number> numbers_;
  std::vector<double> sweep_rad_;
  std::vector<double> line_rad_;
};

}  // namespace

Result<SequenceHeader> read_kretz_header(const NamedFile& from) {
  return KretzHeader(from).read();
}

}  // namespace fanlight
