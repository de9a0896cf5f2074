// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/dicom_nesting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string_view>
#include <vector>

#include "acquisition/replay/inflater.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

constexpr std::uint64_t kFirstElement = 132;
constexpr std::size_t kMostDepth = 64;  // PS3.3 needs about 6
constexpr std::uint32_t kNotGiven = 0xFFFF'FFFF;
constexpr std::uint64_t kOpen = std::numeric_limits<std::uint64_t>::max();

constexpr std::uint32_t tag(std::uint32_t group, std::uint32_t element) {
  return group << 16 | element;
}
constexpr std::uint32_t kTransferSyntax = tag(0x0002, 0x0010);
constexpr std::uint32_t kPixelData = tag(0x7FE0, 0x0010);
constexpr std::uint32_t kItem = tag(0xFFFE, 0xE000);
constexpr std::uint32_t kItemEnd = tag(0xFFFE, 0xE00D);
constexpr std::uint32_t kSequenceEnd = tag(0xFFFE, 0xE0DD);

/// Types whose length has four bytes, behind two that are reserved.
constexpr std::string_view kLongTypes[] = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                           "SV", "UC", "UN", "UR", "UT", "UV"};
constexpr std::string_view kImplicit = "1.2.840.10008.1.2";
constexpr std::string_view kBigEndian = "1.2.840.10008.1.2.2";
constexpr std::string_view kDeflated = "1.2.840.10008.1.2.1.99";
constexpr std::string_view kOfDicom = "1.2.840.10008.1.2.";

struct Level {
  std::uint64_t end = kOpen;  // offset in the file
  bool is_implicit = false;   // elements inside have no type
  bool has_fragments = false;
};

class Walk {
 public:
  Walk(std::FILE* file, std::uint64_t bytes, const std::string& name)
      : file_(file), bytes_(bytes), name_(name) {}

  Result<void> go() {
    if (!seek(kFirstElement)) return bad("the file is cut off", "the elements of a DICOM file");
    while (at_ < bytes_) {
      while (!levels_.empty() && at_ >= levels_.back().end) levels_.pop_back();
      const std::uint64_t begun = at_;
      if (auto taken = take_element(); !taken) return taken;
      if (failed_) {
        // DCMTK says what a file lacks that ends within an element.
        if (at_ >= bytes_) return {};
        return bad(fmt::format("at byte {} there is no element of a DICOM file", begun), "one that is whole");
      }
      if (levels_.size() > kMostDepth)
        return bad(fmt::format("at byte {} its sequences are over {} deep", begun, kMostDepth),
                   "fewer inside each other");
    }
    return {};
  }

 private:
  Error bad(std::string_view wrong, std::string_view expected, ErrorCode code = ErrorCode::kBadInput) const {
    return {code, fmt::format("{}: {}, expected {}", name_, wrong, expected)};
  }

  bool seek(std::uint64_t to) {
    at_ = std::min(to, bytes_);
    return std::fseek(file_, static_cast<long>(at_), SEEK_SET) == 0;
  }
  /// Reads over bytes without a new buffer, where they are few.
  void skip(std::uint64_t bytes) {
    constexpr std::uint64_t kFew = 512;
    std::array<char, kFew> few{};
    if (bytes > kFew || bytes > bytes_ - at_) {
      failed_ = failed_ || !seek(at_ + bytes);
    } else {
      read(few.data(), bytes);
    }
  }
  void read(void* to, std::size_t bytes) {
    const std::size_t present = std::fread(to, 1, bytes, file_);
    at_ += present;
    failed_ = failed_ || present != bytes;
  }
  std::uint32_t number(std::size_t bytes) {
    std::array<std::uint8_t, 4> from{};
    read(from.data(), bytes);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i)
      value |= std::uint32_t{from[i]} << (8 * (big_endian_ ? bytes - 1 - i : i));
    return value;
  }

  Result<void> take_element() {
    if (is_meta_) {
      // Group 2 is explicit and little endian, and ends where another group begins.
      const std::uint32_t group = number(2);
      if (failed_) return {};
      if (group != 2) {
        if (auto known = leave_meta(); !known) return known;
        seek(at_ - 2);
        is_meta_ = false;
        return {};
      }
      take_field(tag(group, number(2)));
      return {};
    }
    const std::uint32_t group = number(2);
    const std::uint32_t key = tag(group, number(2));
    if (failed_) return {};
    if (group == 0xFFFE) {
      take_delimiter(key);
    } else {
      take_field(key);
    }
    return {};
  }

  Result<void> leave_meta() {
    if (syntax_ == kDeflated)
      return bad("the DICOM file is deflated", "it inflated, as dcmconv +te makes it",
                 ErrorCode::kUnsupported);
    if (syntax_ != kImplicit && !syntax_.starts_with(kOfDicom))
      return bad(fmt::format("its transfer syntax is {}", in_quotes(syntax_)), "one of DICOM's own",
                 ErrorCode::kUnsupported);
    big_endian_ = syntax_ == kBigEndian;
    is_implicit_ = syntax_ == kImplicit;
    return {};
  }

  void take_delimiter(std::uint32_t key) {
    const std::uint32_t length = number(4);
    const bool inside = !levels_.empty();
    if (key == kItem && inside) {
      if (levels_.back().has_fragments) return skip(length);
      levels_.push_back(
          {.end = length == kNotGiven ? kOpen : at_ + length, .is_implicit = levels_.back().is_implicit});
    } else if ((key == kItemEnd || key == kSequenceEnd) && inside && levels_.back().end == kOpen) {
      levels_.pop_back();
    } else {
      failed_ = true;
    }
  }

  void take_field(std::uint32_t key) {
    const bool implicit = levels_.empty() ? is_implicit_ : levels_.back().is_implicit;
    std::array<char, 2> type{};
    bool long_length = implicit;
    if (!implicit) {
      read(type.data(), 2);
      const bool letters = std::ranges::all_of(type, [](char c) { return c >= 'A' && c <= 'Z'; });
      if (!letters) failed_ = true;
      long_length = std::ranges::find(kLongTypes, std::string_view(type.data(), 2)) != std::end(kLongTypes);
      if (long_length) skip(2);
    }
    const std::uint32_t length = number(long_length ? 4 : 2);
    if (failed_) return;
    const std::string_view name(type.data(), 2);
    const bool in_items = (name == "SQ" || implicit) && begins_with_item(length);
    if (length == kNotGiven && long_length) {
      // What has a type that is not known is implicit inside.
      levels_.push_back({.is_implicit = implicit || name == "UN",
                         .has_fragments = key == kPixelData || name == "OB" || name == "OW"});
    } else if (in_items) {
      levels_.push_back({.end = at_ + length, .is_implicit = implicit});
    } else if (key == kTransferSyntax && is_meta_) {
      syntax_.assign(std::min<std::uint32_t>(length, 64), '\0');
      read(syntax_.data(), syntax_.size());
      syntax_.erase(std::find(syntax_.begin(), syntax_.end(), '\0'), syntax_.end());
      skip(length - std::min<std::uint32_t>(length, 64));
    } else {
      skip(length);
    }
  }

  bool begins_with_item(std::uint32_t length) {
    constexpr std::uint32_t kItemBytes = 8;
    if (length == kNotGiven || length < kItemBytes || bytes_ - at_ < kItemBytes) return false;
    const std::uint64_t here = at_;
    const std::uint32_t group = number(2);
    const bool is_item = tag(group, number(2)) == kItem;
    seek(here);
    return is_item;
  }

  std::FILE* file_;
  std::uint64_t bytes_;
  const std::string& name_;
  std::uint64_t at_ = 0;
  bool failed_ = false;
  bool is_meta_ = true;
  bool big_endian_ = false;
  bool is_implicit_ = false;
  std::string syntax_;
  std::vector<Level> levels_;
};

}  // namespace

Result<void> check_dicom_nesting(const std::filesystem::path& path, const std::string& name) {
  const File file(std::fopen(path.c_str(), "rbe"));
  std::error_code failure;
  const std::uint64_t bytes = std::filesystem::file_size(path, failure);
  if (file == nullptr || failure) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{}: the file cannot be opened, expected one that this user may read", name)};
  }
  return Walk(file.get(), bytes, name).go();
}

}  // namespace fanlight
