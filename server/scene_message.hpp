#pragma once

#include <functional>
#include <string>
#include <variant>

#include "proto/fanlight.pb.h"
#include "proto/result.hpp"
#include "proto/scene.hpp"

namespace fanlight {

/// A scene as a message with every field present.
v1::Scene scene_message(const Scene& scene);

/// `scene` with the fields that `change` holds, each checked against the table, and the whole checked. The
/// first field that is refused makes an Error, and nothing is taken; `refused` then points at its row, where
/// it was one field alone.
Result<Scene> changed_scene(const Scene& scene, const v1::Scene& change,
                            const SceneField** refused = nullptr);

/// Calls `each` with the row and the value, a number or a text, of every field that the change holds.
void for_each_change(const v1::Scene& change,
                     const std::function<void(const SceneField&, std::variant<double, std::string>)>& each);

/// Puts a value into a change: a number, or a text where the field is one.
void put_change(v1::Scene& change, const SceneField& field, const std::variant<double, std::string>& value);

/// A refusal with what the field may be.
void describe(v1::Error& message, const Error& error, const SceneField* field);

/// The table of fields, for the hello.
void add_scene_fields(v1::Hello& hello);

}  // namespace fanlight
