// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace fanlight {

/// The text with `name` in place of each mention of the path: displays do not learn where files lie, nor what
/// they are called, since that may be a patient's name. An empty path changes nothing.
inline std::string without_path(std::string text, std::string_view path, std::string_view name) {
  if (path.empty()) return text;
  for (std::size_t at = text.find(path); at != std::string::npos; at = text.find(path, at + name.size()))
    text.replace(at, path.size(), name);
  return text;
}

}  // namespace fanlight
