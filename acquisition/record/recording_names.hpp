// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>

#include "proto/base/result.hpp"
#include "proto/exchange/recording_link.hpp"

namespace fanlight {

/// Whether `path` can be the name of a recording: it ends with .mha (one file) or .mhd (the header, and
/// next to it the pixels in a file .raw or .zraw). kInvalidArgument says what was expected.
Result<void> check_recording_name(const std::filesystem::path& path);
/// The file with the pixels of an .mhd: x.igs.mhd -> x.igs.raw or x.igs.zraw.
std::filesystem::path pixels_path_of(const std::filesystem::path& path, PixelForm form);

/// The lines about the pictures that displays saw: x.igs.mha -> x.igs.mha.pictures.jsonl.
std::filesystem::path picture_notes_path_of(const std::filesystem::path& path);

/// Whether nothing of a recording of this name is there, in either form.
bool is_free_name(const std::filesystem::path& path);

/// Whether two names are those of one file.
bool same_file(const std::filesystem::path& one, const std::filesystem::path& other);

/// kInvalidArgument: the name is none of a recording's, or something has it, or a name that follows from it.
Result<void> check_free_name(const std::filesystem::path& path);

/// x.igs.mha -> x-2.igs.mha; the first file of a recording has the name itself.
std::filesystem::path file_of_recording(const std::filesystem::path& path, std::uint32_t number);

}  // namespace fanlight
