// SPDX-License-Identifier: Apache-2.0
#include "proto/model/cut_list.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <optional>

namespace fanlight {

namespace {

// Of the words of CutList::Kind.
constexpr std::string_view kKinds[] = {"inside", "outside", "balls"};
constexpr float kFarthestMm = 3000;
constexpr float kFarthestEyeMm = 1e5F;
constexpr float kMostRadiusMm = 100;
constexpr float kLeastRadiusMm = 0.5F;
constexpr std::size_t kLeastCorners = 3;
constexpr std::string_view kExpected =
    "expected \"inside NEAREST FARTHEST from X Y Z right X Y Z up X Y Z eye MM outline X Y X Y X Y\", the "
    "same "
    "with \"outside\", or \"balls RADIUS at X Y Z\", separated by semicolons: NEAREST below FARTHEST, right "
    "and "
    "up of length 1 at right angles, three corners or more, a radius of 0.5 to 100 mm, lengths up to 3000 mm";

Error refused(const std::string& wrong) {
  return {ErrorCode::kInvalidArgument, fmt::format("{}, {}", wrong, kExpected)};
}

Error too_many(const std::string& what) {
  return {ErrorCode::kInvalidArgument, fmt::format("the cuts have {}, expected fewer", what)};
}

/// Takes words from the front of a text.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) { skip(); }

  bool at_end() const { return text_.empty(); }

  std::string_view next() {
    const std::string_view word = text_.substr(0, text_.find_first_of(" \n\r\t"));
    text_.remove_prefix(word.size());
    skip();
    return word;
  }

  bool takes(std::string_view word) { return next() == word; }

  bool takes(float& value, float most = kFarthestMm) {
    const std::string_view word = next();
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    return failure == std::errc{} && end == word.data() + word.size() && std::abs(value) <= most;
  }

  bool takes(CutList::Vector& vector) {
    return std::ranges::all_of(vector, [this](float& value) { return takes(value); });
  }

 private:
  void skip() { text_.remove_prefix(std::min(text_.find_first_not_of(" \n\r\t"), text_.size())); }

  std::string_view text_;
};

float dot(const CutList::Vector& a, const CutList::Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

bool are_axes(const CutList::Vector& right, const CutList::Vector& up) {
  constexpr float kRounding = 1e-3F;
  return std::abs(dot(right, right) - 1) < kRounding && std::abs(dot(up, up) - 1) < kRounding &&
         std::abs(dot(right, up)) < kRounding;
}

bool read_lasso(Words& words, CutList::Cut& cut) {
  return words.takes(cut.nearest_mm) && words.takes(cut.farthest_mm) && cut.nearest_mm < cut.farthest_mm &&
         words.takes("from") && words.takes(cut.origin) && words.takes("right") && words.takes(cut.right) &&
         words.takes("up") && words.takes(cut.up) && are_axes(cut.right, cut.up) && words.takes("eye") &&
         words.takes(cut.eye_mm, kFarthestEyeMm) && cut.eye_mm >= 0 && words.takes("outline");
}

bool read_balls(Words& words, CutList::Cut& cut) {
  return words.takes(cut.radius_mm) && cut.radius_mm >= kLeastRadiusMm && cut.radius_mm <= kMostRadiusMm &&
         words.takes("at");
}

}  // namespace

Result<void> CutList::add(std::string_view text) {
  const std::size_t place = cut_count_ + 1;
  if (place > kMostCuts) return too_many(fmt::format("more than {} cuts", kMostCuts));
  Words words(text);
  const auto kind = std::ranges::find(kKinds, words.next());
  Cut cut{.kind = static_cast<Kind>(kind - std::begin(kKinds)), .first = number_count_};
  const Error unread = refused(fmt::format("cut {} cannot be read", place));
  if (kind == std::end(kKinds)) return unread;
  const bool is_lasso = cut.kind != Kind::kBalls;
  if (!(is_lasso ? read_lasso(words, cut) : read_balls(words, cut))) return unread;
  while (!words.at_end()) {
    if (number_count_ == kMostNumbers) return too_many(fmt::format("more than {} coordinates", kMostNumbers));
    if (!words.takes(numbers_[number_count_])) return unread;
    ++number_count_;
  }
  cut.count = number_count_ - cut.first;
  const std::size_t dimensions = is_lasso ? 2 : 3;
  if (cut.count % dimensions != 0 || cut.count < (is_lasso ? 2 * kLeastCorners : dimensions)) return unread;
  cuts_[cut_count_++] = cut;
  return {};
}

Result<CutList> CutList::parse(std::string_view text) {
  if (text.size() > kMostText) return too_many(fmt::format("more than {} characters", kMostText));
  CutList made;
  while (!Words(text).at_end()) {
    const std::size_t end = std::min(text.find(';'), text.size());
    if (auto added = made.add(text.substr(0, end)); !added) return added.error();
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return made;
}

std::string CutList::text() const {
  std::string text;
  for (const Cut& cut : cuts()) {
    if (!text.empty()) text += "; ";
    text += kKinds[static_cast<std::size_t>(cut.kind)];
    if (cut.kind == Kind::kBalls) {
      text += fmt::format(" {} at", cut.radius_mm);
    } else {
      text += fmt::format(" {} {} from {} right {} up {} eye {} outline", cut.nearest_mm, cut.farthest_mm,
                          fmt::join(cut.origin, " "), fmt::join(cut.right, " "), fmt::join(cut.up, " "),
                          cut.eye_mm);
    }
    for (const float number : numbers(cut)) fmt::format_to(std::back_inserter(text), " {}", number);
  }
  return text;
}

bool CutList::continues(const CutList& earlier) const {
  if (cut_count_ < earlier.cut_count_ || number_count_ < earlier.number_count_) return false;
  for (std::size_t place = 0; place < earlier.cut_count_; ++place) {
    const Cut& before = earlier.cuts_[place];
    Cut now = cuts_[place];
    const bool grows =
        place + 1 == earlier.cut_count_ && now.kind == Kind::kBalls && now.count > before.count;
    if (grows) now.count = before.count;
    if (now != before) return false;
  }
  return std::equal(earlier.numbers_.begin(), earlier.numbers_.begin() + earlier.number_count_,
                    numbers_.begin());
}

}  // namespace fanlight
