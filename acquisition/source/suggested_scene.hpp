// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "acquisition/source/frame_source.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// The scene for a source without any option set: scene_for() of its fan, which looks at
/// SourceDescription::subject where it names one.
Scene suggested_scene(const SourceDescription& source, std::uint32_t picture_height = 512);

}  // namespace fanlight
