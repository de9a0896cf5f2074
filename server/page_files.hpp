#pragma once

#include <span>
#include <string_view>

namespace fanlight {

/// A file of the viewer's page, embedded when the project is built.
struct PageFile {
  std::string_view name;  ///< "index.html", "viewer.js", ...
  std::string_view bytes;
};

std::span<const PageFile> page_files();

}  // namespace fanlight
