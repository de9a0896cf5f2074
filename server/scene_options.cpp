#include "server/scene_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <charconv>

namespace fanlight {

namespace {

std::string help_of(const SceneField& field) {
  if (field.is_text()) return std::string(field.help);
  const std::string allowed = field.choices.empty()
                                  ? fmt::format("{} to {}{}{}", field.minimum, field.maximum,
                                                field.unit.empty() ? "" : " ", field.unit)
                                  : fmt::format("{}", fmt::join(field.choices, ", "));
  return fmt::format("{} ({})", field.help, allowed);
}

}  // namespace

void SceneOptions::add_to(CLI::App& command) {
  for (const SceneField& field : scene_fields()) {
    auto& given = given_.emplace_back(&field, "");
    command.add_option(fmt::format("--{}", field.name), given.second, help_of(field))
        ->type_name(field.is_text() ? "TEXT" : field.choices.empty() ? "NUMBER" : "NAME")
        ->group("Scene (what is not given follows from the fan's geometry)");
  }
}

Result<Scene> SceneOptions::applied_to(Scene scene) const {
  for (const auto& [field, text] : given_) {
    if (text.empty()) continue;
    if (auto set = set_field(scene, *field, std::string_view(text)); !set) return set.error();
  }
  if (auto whole = check(scene); !whole) return whole.error();
  return scene;
}

Result<PictureSize> parse_picture_size(const std::string& text) {
  constexpr std::uint32_t kSmallest = 16;
  constexpr std::uint32_t kLargest = 2048;  // on a processor the lights of one larger take seconds
  PictureSize size{};
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  const bool cross = width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x';
  const auto height = cross ? std::from_chars(width.ptr + 1, end, size.height) : width;
  const auto fits = [](std::uint32_t side) { return side >= kSmallest && side <= kLargest; };
  if (!cross || height.ec != std::errc{} || height.ptr != end || !fits(size.width) || !fits(size.height)) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("the picture size is \"{}\", expected WIDTHxHEIGHT such as 512x512, {} to {} each", text,
                    kSmallest, kLargest)};
  }
  return size;
}

}  // namespace fanlight
