// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

namespace fanlight {

/// A file of the viewer's page, embedded in the program at build time.
struct PageFile {
  std::string_view name;  ///< "index.html", "viewer.js", ...
  std::string_view bytes;
  std::string_view gzip;  ///< the same, compressed
};

/// All files of the page.
std::span<const PageFile> page_files();

/// That of them into which SharedPage writes surfaces.
std::string_view shared_page_template();

}  // namespace fanlight
