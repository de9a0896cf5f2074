// SPDX-License-Identifier: Apache-2.0
#include "server/state/preset_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "proto/base/printable.hpp"
#include "proto/model/preset.hpp"
#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

/// Groups of fields that a preset leaves as they are.
constexpr std::string_view kLeftAlone[] = {"camera", "rays", "crop", "cuts", "slice", "deadline"};

v1::Scene preset_part(const v1::Scene& scene, PresetStore::Cuts cuts) {
  v1::Scene part;
  for_each_change(scene, [&](const SceneField& field, const auto& value) {
    const std::string_view group = field.name.substr(0, field.name.find('.'));
    const bool is_wanted = cuts == PresetStore::Cuts::kSaved && group == "cuts";
    if (is_wanted || std::ranges::find(kLeftAlone, group) == std::end(kLeftAlone))
      put_change(part, field, value);
  });
  return part;
}

/// Of letters in ASCII: buttons that differ by a capital alone are one for a reader.
bool is_equal_but_for_case(std::string_view a, std::string_view b) {
  const auto lower = [](char letter) {
    return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
  };
  return std::ranges::equal(a, b, {}, lower, lower);
}

Result<void> check_name(const std::string& name) {
  const bool is_clean = printable(name) == name && name.find_first_not_of(' ') != std::string::npos &&
                        name.front() != ' ' && name.back() != ' ';
  if (!is_clean || name.size() > PresetStore::kLongestName) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("a preset needs a name of 1 to {} characters, without control characters, or "
                             "spaces at its ends",
                             PresetStore::kLongestName)};
  }
  const auto is_same = [&name](const fanlight::Preset& built_in) {
    return is_equal_but_for_case(built_in.name, name);
  };
  if (std::ranges::none_of(presets(), is_same)) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("{} is a built-in preset, expected another name", name)};
}

}  // namespace

Result<void> PresetStore::check_author(std::string_view name, const Author& author) const {
  const auto found = std::ranges::find(presets_, name, &Preset::name);
  if (found == presets_.end() || !found->author.is_admin || author.is_admin) return {};
  return Error{
      ErrorCode::kUnavailable,
      fmt::format("an admin has saved the preset {}, expected an admin to change it, or another name", name)};
}

Result<void> PresetStore::save(const std::string& name, const v1::Scene& scene, const Author& author,
                               Cuts cuts) {
  thread_owner_.check();
  if (auto named = check_name(name); !named) return named;
  if (auto allowed = check_author(name, author); !allowed) return allowed;
  v1::Scene part = preset_part(scene, cuts);
  if (part.ByteSizeLong() == 0) {
    return Error{ErrorCode::kInvalidArgument,
                 "the scene has no field of a preset, expected some of light, material, detector, ..."};
  }
  if (auto valid = changed_scene(Scene{}, part); !valid) return valid.error();
  const auto place = std::ranges::lower_bound(presets_, name, {}, &Preset::name);
  Preset preset{.name = name, .author = author, .scene = std::move(part)};
  if (place != presets_.end() && place->name == name) {
    *place = std::move(preset);
    changed_();
    return {};
  }
  if (presets_.size() >= kMost) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("there are {} presets already, expected one to be removed first", kMost)};
  }
  presets_.insert(place, std::move(preset));
  changed_();
  return {};
}

Result<void> PresetStore::remove(std::string_view name, const Author& author) {
  thread_owner_.check();
  const auto found = std::ranges::find(presets_, name, &Preset::name);
  if (found == presets_.end()) {
    return Error{ErrorCode::kNotFound, fmt::format("there is no saved preset {}, expected the name of one",
                                                   printable(std::string(name.substr(0, kLongestName))))};
  }
  if (auto allowed = check_author(name, author); !allowed) return allowed;
  presets_.erase(found);
  changed_();
  return {};
}

Result<void> PresetStore::request(const v1::PresetRequest& request, const v1::Scene& in_force,
                                  const Author& author) {
  thread_owner_.check();
  switch (request.wish_case()) {
    case v1::PresetRequest::kSave:
      return save(request.save().name(), request.save().has_scene() ? request.save().scene() : in_force,
                  author, request.with_cuts() ? Cuts::kSaved : Cuts::kLeftAlone);
    case v1::PresetRequest::kRemove:
      return remove(request.remove(), author);
    case v1::PresetRequest::WISH_NOT_SET:
      break;
  }
  return Error{ErrorCode::kInvalidArgument, "the wish is not known, expected save or remove"};
}

v1::PresetList PresetStore::message() const {
  v1::PresetList list;
  for (const Preset& preset : presets_) {
    v1::PresetList::Saved& saved = *list.add_saved();
    saved.mutable_preset()->set_name(preset.name);
    saved.mutable_preset()->set_help("saved by " + preset.author.name);
    *saved.mutable_preset()->mutable_scene() = preset.scene;
    saved.set_by_admin(preset.author.is_admin);
  }
  return list;
}

std::string PresetStore::json() const {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Preset& preset : presets_) {
    list.push_back({{"name", preset.name},
                    {"saved_by", preset.author.name},
                    {"admin", preset.author.is_admin},
                    {"scene", change_json(preset.scene)}});
  }
  const nlohmann::ordered_json whole = {{"presets", list}};
  return whole.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::vector<std::string> PresetStore::load(const std::filesystem::path& file) {
  constexpr std::uintmax_t kMostBytes = 10'000'000;
  std::error_code failure;
  if (file.empty() || !std::filesystem::exists(file, failure)) {
    if (!failure) return {};
    return {fmt::format("{}: the presets cannot be read ({})", file.string(), failure.message())};
  }
  const auto foreign = [&](const std::string& why) {
    return fmt::format("{}: {}, expected presets as this server saves them", file.string(), why);
  };
  std::ifstream in(file, std::ios::binary);
  if (!in) return {foreign("it cannot be read")};
  if (std::filesystem::file_size(file, failure) > kMostBytes) return {foreign("it is too large")};
  const std::string text(std::istreambuf_iterator<char>(in), {});
  const auto whole = nlohmann::json::parse(text, nullptr, false);
  if (!whole.is_object() || !whole.contains("presets") || !whole["presets"].is_array())
    return {foreign("it has no list of presets")};
  std::vector<std::string> troubles;
  PresetStore read;
  for (const auto& each : whole["presets"]) {
    if (const auto taken = read.take_entry(each); !taken) troubles.push_back(foreign(taken.error().message));
  }
  presets_ = std::move(read.presets_);
  return troubles;
}

Result<void> PresetStore::take_entry(const nlohmann::json& entry) {
  if (!entry.is_object() || !entry.contains("scene"))
    return Error{ErrorCode::kInvalidArgument, "an entry is no preset"};
  const auto text_of = [&](const char* key) {
    const auto found = entry.find(key);
    return found != entry.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  const auto admin = entry.find("admin");
  const auto scene = scene_change_from_json(entry["scene"]);
  const Author author{.name = printable(text_of("saved_by")),
                      .is_admin = admin != entry.end() && admin->is_boolean() && admin->get<bool>()};
  // A file has cuts only where they were wanted.
  const auto saved =
      scene ? save(text_of("name"), *scene, author, Cuts::kSaved) : Result<void>(scene.error());
  if (saved) return {};
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("the preset {}: {}", printable(text_of("name")), saved.error().message)};
}

}  // namespace fanlight
