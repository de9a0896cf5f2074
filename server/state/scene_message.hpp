// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <variant>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/scene.hpp"

namespace fanlight {

/// The scene as a message with every field present.
v1::Scene scene_message(const Scene& scene);

/// `scene` with the fields of `change`, each checked against the table of fields, and the whole scene
/// checked. Error: the first field that is refused, or the combination. `refused`, if given, receives the row
/// of the refused field, or null if the combination was refused.
Result<Scene> changed_scene(const Scene& scene, const v1::Scene& change,
                            const SceneField** refused = nullptr);

/// Calls `each` with the row and the value (number or text) of every field of the change.
void for_each_change(const v1::Scene& change,
                     const std::function<void(const SceneField&, std::variant<double, std::string>)>& each);

/// Sets a field of the change. `value`: a text for text fields, else a number.
void put_change(v1::Scene& change, const SceneField& field, const std::variant<double, std::string>& value);

/// Writes an error, with the allowed values of `field` unless that is null.
void describe(v1::Error& message, const Error& error, const SceneField* field);

/// Adds the table of fields to the hello.
void add_scene_fields(v1::Hello& hello);

/// Adds the looks, with the fields that each sets.
void add_looks(v1::Hello& hello);

/// The built-in presets.
void add_presets(v1::Hello& hello);

}  // namespace fanlight
