#pragma once

#include <nlohmann/json_fwd.hpp>

#include "proto/fanlight.pb.h"
#include "proto/result.hpp"
#include "proto/scene.hpp"

namespace fanlight {

/// A scene as JSON: {"light": {"right_mm": -60, ...}, "mode": "surface", ...}, choices by name.
nlohmann::ordered_json scene_json(const Scene& scene);

/// The reverse, for some of the fields; what a number or a name may be is left to changed_scene(). Error,
/// kInvalidArgument: a name that no field has, or a value of another kind.
Result<v1::Scene> scene_change_from_json(const nlohmann::json& change);

/// The fields that a change holds, in the same form.
nlohmann::ordered_json change_json(const v1::Scene& change);

/// What one field may be: {"field": ..., "minimum": ..., "maximum": ...} or "choices".
nlohmann::ordered_json range_json(const SceneField& field);

}  // namespace fanlight
