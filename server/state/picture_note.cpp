// SPDX-License-Identifier: Apache-2.0
#include "server/state/picture_note.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::uint32_t kMostSide = 16'384;

bool is_possible(PictureSize size) {
  return size.width > 0 && size.height > 0 && size.width <= kMostSide && size.height <= kMostSide;
}

std::optional<NotedPicture> picture_of(const json& line) {
  NotedPicture picture{.picture_id = line.at("picture"),
                       .source_volume_index = line.at("volume"),
                       .first_frame_sequence = line.at("first_frame"),
                       .last_frame_sequence = line.at("last_frame"),
                       .angle_correction_rad = line.at("angle_correction_rad"),
                       .scene_revision = line.at("scene_revision"),
                       .measures = {.coarse = line.at("coarse"),
                                    .wide_step = line.at("wide_step"),
                                    .cheap_filters = line.at("cheap_filters")},
                       .levels = {},
                       .size = {.width = line.at("width"), .height = line.at("height")},
                       .usual = {}};
  picture.usual = {.width = line.value("usual_width", picture.size.width),
                   .height = line.value("usual_height", picture.size.height)};
  if (const json& levels = line.at("levels"); levels.is_object() && levels.contains("flat")) {
    // Recordings before 2026-11-26 say no more.
    picture.levels = {.fluid = levels.value("fluid", 0.0),
                      .tissue = levels.value("tissue", 0.0),
                      .noise = levels.value("noise", 0.0),
                      .flat = levels.at("flat")};
  } else if (!levels.is_null()) {
    picture.levels = {.fluid = levels.at("fluid"),
                      .tissue = levels.at("tissue"),
                      .noise = levels.at("noise"),
                      .known = true};
  }
  return is_possible(picture.size) && is_possible(picture.usual) ? std::optional(picture) : std::nullopt;
}

bool add_scene(const json& line, PictureNotes& notes) {
  const auto change = scene_change_from_json(line.at("scene"));
  if (!change) return false;
  const auto scene = changed_scene(Scene(), *change);
  if (!scene) return false;
  notes.scenes.insert_or_assign(line.at("scene_revision").get<std::uint64_t>(), *scene);
  return true;
}

bool add_line(const json& line, PictureNotes& notes) {
  try {
    if (line.contains("scene")) return add_scene(line, notes);
    const auto picture = picture_of(line);
    if (picture) notes.pictures.push_back(*picture);
    return picture.has_value();
  } catch (const json::exception&) {
    return false;  // a field is missing, or has another type
  }
}

}  // namespace

std::string scene_note(std::uint64_t revision, const Scene& scene) {
  return ordered_json({{"scene_revision", revision}, {"scene", scene_json(scene)}}).dump();
}

std::string picture_note(const PictureStamp& stamp, PictureSize size, PictureSize usual) {
  const EchoLevels& levels = stamp.levels;
  ordered_json known = nullptr;
  if (levels.known || levels.flat)
    known = {{"fluid", levels.fluid}, {"tissue", levels.tissue}, {"noise", levels.noise}};
  if (levels.flat) known["flat"] = true;
  ordered_json note({{"picture", stamp.picture_id},
                     {"volume", stamp.volume.source_volume_index},
                     {"first_frame", stamp.volume.first_frame_sequence},
                     {"last_frame", stamp.volume.last_frame_sequence},
                     {"angle_correction_rad", stamp.volume.angle_correction_rad},
                     {"scene_revision", stamp.scene_revision},
                     {"coarse", stamp.measures.coarse},
                     {"wide_step", stamp.measures.wide_step},
                     {"cheap_filters", stamp.measures.cheap_filters},
                     {"levels", known},
                     {"width", size.width},
                     {"height", size.height}});
  if (size != usual) {
    note["usual_width"] = usual.width;
    note["usual_height"] = usual.height;
  }
  return note.dump();
}

Result<PictureNotes> read_picture_notes(const std::filesystem::path& path) {
  constexpr std::size_t kLongestLine = 100'000;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{} cannot be read, expected the notes that fanlight serve writes next to a "
                             "recording",
                             path.string())};
  }
  PictureNotes notes;
  std::string text;
  for (std::size_t number = 1; std::getline(file, text); ++number) {
    const json line = text.size() > kLongestLine ? json() : json::parse(text, nullptr, false);
    if (!line.is_object() || !add_line(line, notes)) {
      return Error{ErrorCode::kBadInput, fmt::format("{}: line {} is no scene and no picture, expected one",
                                                     path.string(), number)};
    }
  }
  return notes;
}

}  // namespace fanlight
