// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

namespace fanlight {

/// A format that Fanlight does not read.
struct ForeignFormat {
  std::string_view what;    ///< "a NRRD file"
  std::string_view advice;  ///< what to do with it
};

/// Names the format of a file by its first bytes, else by the end of its name; nullopt: it may be a MetaImage
/// sequence. 400 bytes identify all formats.
std::optional<ForeignFormat> foreign_format(std::span<const unsigned char> first_bytes,
                                            const std::filesystem::path& path);

}  // namespace fanlight
