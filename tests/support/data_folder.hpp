// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <filesystem>

namespace fanlight::test {

/// Folder of the real recordings: the environment variable FANLIGHT_DATA, or shared/data beside the checkout.
/// The recordings may be absent; a test that needs one then skips with a message. Needs the compile
/// definition FANLIGHT_SOURCE_FOLDER.
inline std::filesystem::path data_folder() {
  const char* const configured = std::getenv("FANLIGHT_DATA");
  return configured != nullptr ? configured : FANLIGHT_SOURCE_FOLDER "/../shared/data";
}

}  // namespace fanlight::test
