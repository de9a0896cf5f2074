#pragma once

#include <cstdlib>
#include <filesystem>

namespace fanlight::test {

/// Where the real recordings lie: FANLIGHT_DATA, or shared/data beside the checkout. They may be absent; a
/// test that needs one then skips and says so. Needs the compile definition FANLIGHT_SOURCE_FOLDER.
inline std::filesystem::path data_folder() {
  const char* const named = std::getenv("FANLIGHT_DATA");
  return named != nullptr ? named : FANLIGHT_SOURCE_FOLDER "/../shared/data";
}

}  // namespace fanlight::test
