// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "acquisition/source/frame_source.hpp"
#include "proto/base/result.hpp"
#include "proto/model/scene.hpp"
#include "proto/model/volume.hpp"
#include "renderer/parameters/view_frame.hpp"
#include "server/cli/scene_options.hpp"

namespace fanlight {

/// What --auto chooses for a volume.
struct AutoView {
  Scene scene;
  std::vector<std::string> choices;  ///< a sentence each
  std::string options;               ///< the command line options that give this scene without --auto
};

/// auto_scene() for the volume, and on top of it the options that the user has given. `base`: the scene for
/// the source alone. Where the volume has no surface, its slices. Errors: as of SceneOptions::applied_to().
Result<AutoView> auto_view(const Volume& volume, const Scene& base, const SceneOptions& given,
                           const PictureSize& size);

/// The options --auto and --no-auto; not both are given.
struct AutoOptions {
  bool on = false;
  bool off = false;

  void add_to(CLI::App& command);
};

/// Whether the view is found by auto_view(), or by the server in the same way: as asked, or else where no
/// option chooses a view. What the simulated probe shows is known, so its usual view stays.
bool finds_view(const AutoOptions& asked, const SceneOptions& given, const SourceDescription& source);

}  // namespace fanlight
