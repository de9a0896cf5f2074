// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/scene.hpp"

namespace fanlight {

/// A scene as JSON, with choices by name: {"light": {"right_mm": -60, ...}, "mode": "surface", ...}.
nlohmann::ordered_json scene_json(const Scene& scene);

/// Reads some of the fields from JSON. changed_scene() checks their ranges. Error, kInvalidArgument: there is
/// no field of that name, or the value has the wrong type.
Result<v1::Scene> scene_change_from_json(const nlohmann::json& change);

/// The refusal of a name that no field has, with the field that was probably meant.
Error no_scene_field(const std::string& name);

/// The fields of a change as JSON, in the same form.
nlohmann::ordered_json change_json(const v1::Scene& change);

/// The allowed values of a field: {"field": ..., "minimum": ..., "maximum": ...} or "choices".
nlohmann::ordered_json range_json(const SceneField& field);

}  // namespace fanlight
