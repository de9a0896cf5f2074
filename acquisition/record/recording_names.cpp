// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recording_names.hpp"

#include <fmt/format.h>

#include <string>
#include <system_error>

#include "acquisition/record/segment_paths.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/model/measurement_file.hpp"

namespace fanlight {

Result<void> check_recording_name(const std::filesystem::path& path) {
  if (path.extension() == ".mha" || path.extension() == ".mhd") return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{} is no name of a recording, expected one that ends with .igs.mha (one file) or "
                           ".igs.mhd (with the pixels in a separate file)",
                           shown(path))};
}

std::filesystem::path pixels_path_of(const std::filesystem::path& path, PixelForm form) {
  std::filesystem::path pixels_path = path;
  return pixels_path.replace_extension(form == PixelForm::kZlib ? ".zraw" : ".raw");
}

std::filesystem::path picture_notes_path_of(const std::filesystem::path& path) {
  return path.string() + ".pictures.jsonl";
}

bool is_free_name(const std::filesystem::path& path) {
  std::error_code failure;
  const auto there = [&failure](const std::filesystem::path& each) {
    return std::filesystem::exists(std::filesystem::symlink_status(each, failure));
  };
  std::filesystem::path pair = path;
  pair.replace_extension(".mhd");
  return !there(path) && !there(pair) && !there(pixels_path_of(path, PixelForm::kRaw)) &&
         !there(pixels_path_of(path, PixelForm::kZlib)) && !there(picture_notes_path_of(path)) &&
         !there(picture_notes_path_of(pair)) && !there(measurements_path_of(path)) &&
         !there(measurements_path_of(pair)) && segments_of(path).empty();
}

bool same_file(const std::filesystem::path& one, const std::filesystem::path& other) {
  std::error_code failure;
  return std::filesystem::equivalent(one, other, failure) && !failure;
}

Result<void> check_free_name(const std::filesystem::path& path) {
  if (auto named = check_recording_name(path); !named) return named;
  if (is_free_name(path)) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("{} exists already, or a file that belongs to it (.mhd, .raw, .zraw, .pictures.jsonl, "
                  ".measurements.json, .rec-0001), expected a name that is free",
                  shown(path))};
}

std::filesystem::path file_of_recording(const std::filesystem::path& path, std::uint32_t number) {
  if (number <= 1) return path;
  const std::string name = path.filename().string();
  auto end = name.find(".igs.");
  if (end == std::string::npos) end = name.rfind('.');
  return path.parent_path() / fmt::format("{}-{}{}", name.substr(0, end), number, name.substr(end));
}

}  // namespace fanlight
