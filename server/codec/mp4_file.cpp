// SPDX-License-Identifier: Apache-2.0
#include "server/codec/mp4_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace mp4 {

/// Bytes of boxes, big endian. A box is written with its size once it is closed.
class Boxes {
 public:
  Boxes& u8(std::uint32_t value) {
    bytes_.push_back(static_cast<char>(value));
    return *this;
  }
  Boxes& u16(std::uint32_t value) { return u8(value >> 8).u8(value); }
  Boxes& u32(std::uint32_t value) { return u16(value >> 16).u16(value); }
  Boxes& u64(std::uint64_t value) {
    return u32(static_cast<std::uint32_t>(value >> 32)).u32(static_cast<std::uint32_t>(value));
  }
  Boxes& zeros(std::size_t count) {
    bytes_.append(count, '\0');
    return *this;
  }
  Boxes& text(std::string_view text) {
    bytes_ += text;
    return *this;
  }
  Boxes& bytes(std::span<const std::uint8_t> bytes) {
    bytes_.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return *this;
  }
  template <typename Fill>
  Boxes& box(std::string_view type, Fill fill) {
    const std::size_t begin = bytes_.size();
    u32(0).text(type);
    fill();
    const std::size_t size = bytes_.size() - begin;
    for (std::size_t i = 0; i < 4; ++i) bytes_[begin + i] = static_cast<char>(size >> (24 - 8 * i));
    return *this;
  }
  /// With a version and flags.
  template <typename Fill>
  Boxes& full_box(std::string_view type, std::uint32_t flags, Fill fill) {
    return box(type, [&] {
      u32(flags);
      fill();
    });
  }
  Boxes& unit_matrix() {
    for (const std::uint32_t value : {0x10000U, 0U, 0U, 0U, 0x10000U, 0U, 0U, 0U, 0x40000000U}) u32(value);
    return *this;
  }
  const std::string& all() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace mp4

using mp4::Boxes;

namespace {

constexpr std::uint32_t kTicksPerS = 90'000;
constexpr std::int64_t kNsPerS = 1'000'000'000;
constexpr std::int64_t kShortestNs = 1'000'000;
constexpr std::int64_t kLongestNs = 10 * kNsPerS;
constexpr std::int64_t kUsualNs = 100'000'000;  // of a single picture

std::string file_type() {
  Boxes boxes;
  boxes.box("ftyp", [&] { boxes.text("isom").u32(0x200).text("isomiso2avc1mp41"); });
  return boxes.all();
}

constexpr std::uint64_t kFileTypeBytes = 32;
constexpr std::uint64_t kDataHeaderBytes = 16;

/// The box of the pictures, whose size is given in 64 bits.
std::string data_header(std::uint64_t data_bytes) {
  Boxes boxes;
  boxes.u32(1).text("mdat").u64(kDataHeaderBytes + data_bytes);
  return boxes.all();
}

/// The units of an Annex B stream, without their start codes.
std::vector<std::span<const std::uint8_t>> units_of(std::span<const std::uint8_t> stream) {
  std::vector<std::span<const std::uint8_t>> units;
  const auto start_at = [&](std::size_t from) {
    for (std::size_t i = from; i + 2 < stream.size(); ++i) {
      if (stream[i] == 0 && stream[i + 1] == 0 && stream[i + 2] == 1) return i;
    }
    return stream.size();
  };
  std::size_t at = start_at(0);
  while (at < stream.size()) {
    const std::size_t begin = at + 3;
    at = start_at(begin);
    std::size_t end = at;
    while (end > begin && stream[end - 1] == 0) --end;  // of a start code of four bytes
    if (end > begin) units.push_back(stream.subspan(begin, end - begin));
  }
  return units;
}

}  // namespace

Result<void> Mp4File::as_result(int failure) const {
  if (failure == 0) return {};
  return Error{ErrorCode::kUnavailable,
               fmt::format("{} could not be written ({}), expected an existing folder with free space",
                           printable(path_.string()), write_failure(failure))};
}

Result<void> Mp4File::begin() {
  constexpr mode_t kOwnerOnly = 0600;  // it shows a patient
  target_ = path_;
  if (!beneath_.empty()) {
    auto opened = as_result(folder_.open(beneath_, path_, FolderBeneath::Missing::kFail));
    if (!opened) return opened;
    target_ = folder_.name();
  }
  if (auto made = as_result(file_.create_unnamed(target_, kOwnerOnly)); !made) return made;
  return as_result(write_all(file_.descriptor(), file_type() + data_header(0)));
}

Result<void> Mp4File::add(std::span<const std::uint8_t> annex_b, bool key, std::int64_t time_ns) {
  constexpr std::uint8_t kTypeMask = 0x1F;
  constexpr std::uint8_t kSequenceSet = 7;
  constexpr std::uint8_t kPictureSet = 8;
  if (samples_.empty()) {
    if (auto begun = begin(); !begun) return begun;
  }
  sample_.clear();
  for (const auto unit : units_of(annex_b)) {
    const std::uint8_t type = unit[0] & kTypeMask;
    if (type == kSequenceSet) {
      sequence_set_.assign(unit.begin(), unit.end());
    } else if (type == kPictureSet) {
      picture_set_.assign(unit.begin(), unit.end());
    } else {
      for (int shift = 24; shift >= 0; shift -= 8)
        sample_.push_back(static_cast<std::uint8_t>(unit.size() >> shift));
      sample_.insert(sample_.end(), unit.begin(), unit.end());
    }
  }
  const std::string_view bytes(reinterpret_cast<const char*>(sample_.data()), sample_.size());
  if (auto written = as_result(write_all(file_.descriptor(), bytes)); !written) return written;
  data_bytes_ += sample_.size();
  samples_.push_back({.time_ns = time_ns, .bytes = static_cast<std::uint32_t>(sample_.size()), .key = key});
  return {};
}

std::vector<std::uint32_t> Mp4File::durations() const {
  std::vector<std::uint32_t> ticks;
  std::int64_t last_ns = kUsualNs;
  std::int64_t at_ns = 0;
  const auto tick = [](std::int64_t ns) { return ns * kTicksPerS / kNsPerS; };
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    if (i + 1 < samples_.size())
      last_ns = std::clamp(samples_[i + 1].time_ns - samples_[i].time_ns, kShortestNs, kLongestNs);
    // Of the whole times, so that rounding does not add up.
    ticks.push_back(static_cast<std::uint32_t>(tick(at_ns + last_ns) - tick(at_ns)));
    at_ns += last_ns;
  }
  return ticks;
}

/// Writes the index: the box "moov" with one track.
class Mp4File::Index {
 public:
  explicit Index(const Mp4File& file) : file_(file), ticks_(file.durations()) {
    for (const std::uint32_t each : ticks_) duration_ += each;
    movie();
  }
  const std::string& bytes() const { return out_.all(); }

 private:
  static constexpr std::uint32_t kLong = 1U << 24;  // version 1: times of 64 bits

  void movie() {
    out_.box("moov", [this] {
      out_.full_box("mvhd", kLong, [this] {
        out_.zeros(16).u32(kTicksPerS).u64(duration_).u32(0x10000).u16(0x100).zeros(10).unit_matrix();
        out_.zeros(24).u32(2);
      });
      out_.box("trak", [this] {
        constexpr std::uint32_t kShown = 3;
        out_.full_box("tkhd", kLong | kShown, [this] {
          out_.zeros(16).u32(1).u32(0).u64(duration_).zeros(16).unit_matrix();
          out_.u32(file_.width_ << 16).u32(file_.height_ << 16);
        });
        out_.box("mdia", [this] { media(); });
      });
    });
  }

  void media() {
    constexpr std::uint32_t kNoLanguage = 0x55C4;
    out_.full_box("mdhd", kLong,
                  [this] { out_.zeros(16).u32(kTicksPerS).u64(duration_).u16(kNoLanguage).u16(0); });
    out_.full_box("hdlr", 0, [this] { out_.u32(0).text("vide").zeros(12).text("Fanlight").u8(0); });
    out_.box("minf", [this] {
      out_.full_box("vmhd", 1, [this] { out_.zeros(8); });
      out_.box("dinf",
               [this] { out_.full_box("dref", 0, [this] { out_.u32(1).full_box("url ", 1, [] {}); }); });
      out_.box("stbl", [this] { tables(); });
    });
  }

  void tables() {
    const auto count = static_cast<std::uint32_t>(ticks_.size());
    out_.full_box("stsd", 0, [this] {
      out_.u32(1);
      description();
    });
    out_.full_box("stts", 0, [&] {
      out_.u32(count);
      for (const std::uint32_t each : ticks_) out_.u32(1).u32(each);
    });
    out_.full_box("stss", 0, [&] {
      out_.u32(static_cast<std::uint32_t>(std::ranges::count_if(file_.samples_, &Sample::key)));
      for (std::uint32_t i = 0; i < count; ++i) {
        if (file_.samples_[i].key) out_.u32(i + 1);
      }
    });
    // All pictures are one chunk.
    out_.full_box("stsc", 0, [&] { out_.u32(1).u32(1).u32(count).u32(1); });
    out_.full_box("stsz", 0, [&] {
      out_.u32(0).u32(count);
      for (const Sample& sample : file_.samples_) out_.u32(sample.bytes);
    });
    out_.full_box("co64", 0, [this] { out_.u32(1).u64(kFileTypeBytes + kDataHeaderBytes); });
  }

  void description() {
    out_.box("avc1", [this] {
      constexpr std::uint32_t kDotsPerInch = 0x480000;
      out_.zeros(6).u16(1).zeros(16).u16(file_.width_).u16(file_.height_).u32(kDotsPerInch).u32(kDotsPerInch);
      out_.u32(0).u16(1).zeros(32).u16(24).u16(0xFFFF);
      const auto& sequence = file_.sequence_set_;
      const auto& picture = file_.picture_set_;
      out_.box("avcC", [&] {
        out_.u8(1).u8(sequence[1]).u8(sequence[2]).u8(sequence[3]);
        out_.u8(0xFF).u8(0xE1).u16(static_cast<std::uint32_t>(sequence.size())).bytes(sequence);
        out_.u8(1).u16(static_cast<std::uint32_t>(picture.size())).bytes(picture);
      });
      // BT.709 primaries, sRGB's curve, and the matrix of libyuv's conversion: BT.601, limited range.
      out_.box("colr", [this] { out_.text("nclx").u16(1).u16(13).u16(6).u8(0); });
    });
  }

  const Mp4File& file_;
  std::vector<std::uint32_t> ticks_;
  std::uint64_t duration_ = 0;
  Boxes out_;
};

Result<void> Mp4File::finish() {
  constexpr std::size_t kLeastSet = 4;
  if (sequence_set_.size() < kLeastSet || picture_set_.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "the video has no parameter sets, expected a key picture first"};
  const Index index(*this);
  if (auto written = as_result(write_all(file_.descriptor(), index.bytes())); !written) return written;
  const std::string header = data_header(data_bytes_);
  const ssize_t patched =
      pwrite(file_.descriptor(), header.data(), header.size(), static_cast<off_t>(kFileTypeBytes));
  if (patched != static_cast<ssize_t>(header.size())) return as_result(patched < 0 ? errno : ENOSPC);
  if (auto synced = as_result(file_.sync()); !synced) return synced;
  return as_result(file_.replace(target_));
}

}  // namespace fanlight
