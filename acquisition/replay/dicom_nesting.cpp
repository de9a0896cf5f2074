// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay/dicom_nesting.hpp"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctag.h>
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
// DCMTK keeps an object of some hundred bytes for each, however short it is, and takes 10 microseconds. A
// volume of 10 000 frames has some 300 000.
constexpr std::uint64_t kMostElements = 400'000;
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

constexpr std::string_view kShortTypes[] = {"AE", "AS", "AT", "CS", "DA", "DS", "DT", "FD", "FL", "IS", "LO",
                                            "LT", "PN", "SH", "SL", "SS", "ST", "TM", "UI", "UL", "US"};
/// Types whose length has four bytes, behind two that are reserved.
constexpr std::string_view kLongTypes[] = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                           "SV", "UC", "UN", "UR", "UT", "UV"};

constexpr std::string_view kImplicit = "1.2.840.10008.1.2";
constexpr std::string_view kBigEndian = "1.2.840.10008.1.2.2";
constexpr std::string_view kDeflated = "1.2.840.10008.1.2.1.99";
constexpr std::string_view kReadSyntaxes[] = {
    kImplicit,
    "1.2.840.10008.1.2.1",
    kBigEndian,
    "1.2.840.10008.1.2.5",     // RLE
    "1.2.840.10008.1.2.4.50",  // JPEG
    "1.2.840.10008.1.2.4.51",
    "1.2.840.10008.1.2.4.53",
    "1.2.840.10008.1.2.4.55",
    "1.2.840.10008.1.2.4.57",
    "1.2.840.10008.1.2.4.70",
    "1.2.840.10008.1.2.4.80",  // JPEG-LS
    "1.2.840.10008.1.2.4.81",
};

template <std::size_t kCount>
bool is_one_of(std::string_view text, const std::string_view (&list)[kCount]) {
  return std::ranges::find(list, text) != std::end(list);
}

/// A sequence or an item that is open.
struct Level {
  enum class Kind : std::uint8_t { kSequence, kFragments, kInside };
  Kind kind = Kind::kSequence;
  std::uint64_t end = kOpen;  // offset in the file
  bool is_implicit = false;   // elements inside have no type
};

/// Whatever DCMTK could read in another way than this walk is refused.
class Walk {
 public:
  Walk(std::FILE* file, std::uint64_t bytes, const std::string& name)
      : file_(file), bytes_(bytes), name_(name) {}

  Result<void> go() {
    if (!seek(kFirstElement)) return bad("the file is cut off", "the elements of a DICOM file");
    for (std::uint64_t elements = 0; at_ < bytes_; ++elements) {
      while (!levels_.empty() && at_ == levels_.back().end) levels_.pop_back();
      const std::uint64_t begun = at_;
      if (elements == kMostElements)
        return bad(fmt::format("it has over {} elements and items", kMostElements), "fewer");
      if (auto taken = take_element(); !taken) return taken;
      if (failed_) {
        // DCMTK says what a file lacks that ends within an element.
        if (at_ >= bytes_) return {};
        return bad(fmt::format("at byte {} there is no element of a DICOM file", begun),
                   "elements that are whole, and none behind the data set");
      }
      if (levels_.size() > kMostDepth)
        return bad(fmt::format("at byte {} its sequences are over {} deep", begun, kMostDepth),
                   "fewer inside each other");
      if (!levels_.empty() && at_ > levels_.back().end)
        return bad(fmt::format("the element at byte {} is longer than its item", begun), "one that fits");
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
    if (bytes > bytes_ - at_) failed_ = true;
    if (bytes > kFew || bytes > bytes_ - at_) {
      failed_ = !seek(at_ + bytes) || failed_;
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
    const std::uint32_t group = number(2);
    if (failed_) return {};
    // Group 2 is explicit and little endian, and ends where another group begins.
    if (is_meta_ && group != 2) {
      is_meta_ = false;
      seek(at_ - 2);
      return leave_meta();
    }
    const std::uint32_t key = tag(group, number(2));
    if (failed_) return {};
    if (group == 0xFFFE) {
      take_delimiter(key);
    } else if (!levels_.empty() && levels_.back().kind != Level::Kind::kInside) {
      failed_ = true;  // a sequence has items alone
    } else {
      take_field(key);
    }
    return {};
  }

  Result<void> leave_meta() {
    if (syntax_ == kDeflated)
      return bad("the DICOM file is deflated", "it inflated, as dcmconv +te makes it",
                 ErrorCode::kUnsupported);
    if (!is_one_of(syntax_, kReadSyntaxes)) {
      return bad(fmt::format("its transfer syntax is {}", in_quotes(syntax_)),
                 "one of plain, RLE, JPEG or JPEG-LS pixels", ErrorCode::kUnsupported);
    }
    big_endian_ = syntax_ == kBigEndian;
    is_implicit_ = syntax_ == kImplicit;
    return {};
  }

  void take_delimiter(std::uint32_t key) {
    using Kind = Level::Kind;
    const std::uint32_t length = number(4);
    if (levels_.empty()) {
      failed_ = true;
      return;
    }
    const Level level = levels_.back();
    const bool ends = level.end == kOpen && length == 0;
    if (key == kItem && level.kind == Kind::kFragments && length != kNotGiven) {
      skip(length);
    } else if (key == kItem && level.kind == Kind::kSequence) {
      open({.kind = Kind::kInside, .is_implicit = level.is_implicit}, length);
    } else if ((key == kItemEnd && level.kind == Kind::kInside && ends) ||
               (key == kSequenceEnd && level.kind != Kind::kInside && ends)) {
      levels_.pop_back();
    } else {
      failed_ = true;
    }
  }

  void open(Level level, std::uint32_t length) {
    if (length != kNotGiven) level.end = at_ + length;
    // Inside something that ends before it.
    const std::uint64_t outer = levels_.empty() ? kOpen : levels_.back().end;
    if (level.end != kOpen && level.end > outer) failed_ = true;
    levels_.push_back(level);
  }

  void take_field(std::uint32_t key) {
    using Kind = Level::Kind;
    const bool implicit = levels_.empty() ? is_implicit_ && !is_meta_ : levels_.back().is_implicit;
    const std::string type = implicit ? std::string() : type_of_field();
    const std::uint32_t length = number(implicit || is_one_of(type, kLongTypes) ? 4 : 2);
    if (failed_) return;
    const bool given = length != kNotGiven || (!implicit && !is_one_of(type, kLongTypes));
    const bool bulk = type == "OB" || type == "OW" || (implicit && key == kPixelData);
    if (type == "SQ" || (!given && !bulk) || (implicit && given && is_sequence(key, length))) {
      if (!given && !implicit && type != "SQ" && type != "UN") failed_ = true;
      // What has a type that is not known is implicit inside.
      open({.kind = Kind::kSequence, .is_implicit = implicit || type == "UN"}, length);
    } else if (!given) {
      open({.kind = Kind::kFragments}, length);
    } else if (key == kTransferSyntax && is_meta_) {
      take_syntax(length);
    } else {
      skip(length);
    }
  }

  std::string type_of_field() {
    std::string type(2, '\0');
    read(type.data(), 2);
    const bool is_long = is_one_of(type, kLongTypes);
    if (is_long) skip(2);
    if (!is_long && !is_one_of(type, kShortTypes)) failed_ = true;
    return type;
  }

  void take_syntax(std::uint32_t length) {
    constexpr std::uint32_t kLongestUid = 64;
    if (length > kLongestUid || !syntax_.empty()) {
      failed_ = true;  // a second one could be another
      return;
    }
    syntax_.assign(length, '\0');
    read(syntax_.data(), length);
    while (!syntax_.empty() && (syntax_.back() == '\0' || syntax_.back() == ' ')) syntax_.pop_back();
  }

  /// Without types, DCMTK's dictionary says what is a sequence; or it looks like one.
  bool is_sequence(std::uint32_t key, std::uint32_t length) {
    if (DcmTag(static_cast<Uint16>(key >> 16), static_cast<Uint16>(key)).getEVR() == EVR_SQ) return true;
    constexpr std::uint32_t kItemBytes = 8;
    if (length < kItemBytes || bytes_ - at_ < kItemBytes) return false;
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
