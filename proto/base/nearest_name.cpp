// SPDX-License-Identifier: Apache-2.0
#include "proto/base/nearest_name.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace fanlight {

namespace {

/// The number of letters to change, add, leave out or exchange with their neighbour ("optimal string
/// alignment", a restricted Damerau-Levenshtein distance).
std::size_t distance(std::string_view from, std::string_view to) {
  std::vector<std::size_t> before_last(to.size() + 1);
  std::vector<std::size_t> last(to.size() + 1);
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(last.begin(), last.end(), 0U);
  for (std::size_t i = 1; i <= from.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= to.size(); ++j) {
      const std::size_t changed = last[j - 1] + (from[i - 1] == to[j - 1] ? 0 : 1);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, changed});
      if (i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last.swap(last);
    last.swap(row);
  }
  return last.back();
}

/// "a", "a or b", "a, b or c".
std::string one_of(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t index = 0; index < names.size(); ++index) {
    if (index > 0) text += index + 1 < names.size() ? ", " : " or ";
    text += names[index];
  }
  return text;
}

/// Those of which `part` is the last part: light.kind and filter.kind for kind.
std::vector<std::string> names_ending_in(std::string_view part, const std::vector<std::string>& known) {
  std::vector<std::string> names;
  for (const std::string& name : known) {
    const std::size_t point = name.rfind('.');
    if (point != std::string::npos && name.substr(point + 1) == part) names.push_back(name);
  }
  return names;
}

}  // namespace

std::string nearest_name(std::string_view typed, const std::vector<std::string>& known) {
  constexpr std::size_t kLongest = 64;
  // One letter is near to any other.
  const std::size_t dashes = std::min(typed.find_first_not_of('-'), typed.size());
  if (typed.size() - dashes < 2 || typed.size() > kLongest) return "";
  if (const auto longer = names_ending_in(typed.substr(dashes), known); !longer.empty())
    return one_of(longer);
  std::string best;
  std::size_t fewest = std::max<std::size_t>(1, typed.size() / 3) + 1;
  for (const std::string& name : known) {
    // A name that is only begun is nearer than any with other letters.
    const std::size_t changes = name.starts_with(typed) && typed.size() > 2 ? 1 : distance(typed, name);
    if (changes >= fewest) continue;
    fewest = changes;
    best = name;
  }
  return best;
}

}  // namespace fanlight
