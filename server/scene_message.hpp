#pragma once

#include <string>

#include "proto/fanlight.pb.h"
#include "proto/result.hpp"
#include "proto/scene.hpp"

namespace fanlight {

/// A scene as a message with every field present.
v1::Scene scene_message(const Scene& scene);

/// `scene` with the fields that `change` holds, each checked against the table, and the whole checked. The
/// first field that is refused makes an Error, and nothing is taken.
Result<Scene> changed_scene(const Scene& scene, const v1::Scene& change);

/// The table of fields, for the hello.
void add_scene_fields(v1::Hello& hello);

}  // namespace fanlight
