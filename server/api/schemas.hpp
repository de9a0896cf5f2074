// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "proto/model/scene.hpp"

namespace fanlight {

/// JSON Schemas (draft 2020-12) of the bodies of the REST API, by name. Those of the scene come from the
/// table of its fields, and those of messages from their descriptors, as the bodies do.
nlohmann::ordered_json api_schemas();

/// A field of the scene for GET /api/fields: its name, unit and help; type "number", "integer", "choice" or
/// "text"; and what is allowed.
nlohmann::ordered_json field_json(const SceneField& field);

}  // namespace fanlight
