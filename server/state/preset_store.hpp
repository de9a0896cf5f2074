// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/fanlight.pb.h"

namespace fanlight {

/// The presets that people have saved. Each holds what the picture shows and how: all fields of the scene but
/// those of view and place (camera, rays, crop, slice) and of the deadline; what the scalpel has cut away
/// only if that is wanted. No input or output but load(): the caller that changes something writes json() to
/// the file. Server thread only.
class PresetStore {
 public:
  static constexpr std::size_t kMost = 100;
  static constexpr std::size_t kLongestName = 40;  ///< bytes

  /// Who saves or removes.
  struct Author {
    std::string name;
    bool is_admin = false;
  };
  /// Whether what the scalpel has cut away belongs to a preset.
  enum class Cuts : std::uint8_t { kLeftAlone, kSaved };
  struct Preset {
    std::string name;
    Author author;    ///< of the last change
    v1::Scene scene;  ///< the fields that it sets
  };

  /// `changed`: called after each save() and remove().
  explicit PresetStore(std::function<void()> changed = [] {}) : changed_(std::move(changed)) {}

  /// Reads the presets of an earlier run; a file that is not there has none. Leaves out what it cannot use,
  /// and returns a sentence for each; a file that is none of ours is one sentence.
  std::vector<std::string> load(const std::filesystem::path& file);

  /// Saves the fields of `scene` that belong to a preset, in place of a preset of that name. Errors:
  /// kInvalidArgument for the name, or where no field belongs to a preset; kUnavailable for what an admin has
  /// saved and another wants to replace, and beyond kMost.
  Result<void> save(const std::string& name, const v1::Scene& scene, const Author& author,
                    Cuts cuts = Cuts::kLeftAlone);

  /// Errors as of save(); kNotFound: there is none of that name.
  Result<void> remove(std::string_view name, const Author& author);

  /// In the order of their names.
  const std::vector<Preset>& all() const { return presets_; }

  /// Carries out a request of a client. `in_force`: what is saved where the request has no scene. Errors:
  /// those of save() and remove(), and kInvalidArgument for an unknown wish.
  Result<void> request(const v1::PresetRequest& request, const v1::Scene& in_force, const Author& author);

  v1::PresetList message() const;

  /// The file: {"presets": [{"name": ..., "saved_by": ..., "admin": ..., "scene": {...}}]}, with scenes as
  /// /api/scene has them.
  std::string json() const;

 private:
  Result<void> take_entry(const nlohmann::json& entry);
  Result<void> check_author(std::string_view name, const Author& author) const;

  std::function<void()> changed_;
  std::vector<Preset> presets_;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
