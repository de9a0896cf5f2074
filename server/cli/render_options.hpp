// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/open_source.hpp"
#include "server/cli/auto_view.hpp"
#include "server/cli/picture_series.hpp"
#include "server/cli/scene_options.hpp"

namespace fanlight {

/// What `fanlight render` renders, and each sweep of `fanlight batch`.
struct RenderOptions {
  std::string input;
  SourceOptions playing{.pace = SourcePace::kAsFastAsTaken};
  RenderFiles files;
  bool exports = false;                 // to a page, by `fanlight export`
  std::optional<std::uint64_t> volume;  // absent: the first that the source gives
  bool all = false;
  std::optional<std::int64_t> count;  // of volumes, with `all`; absent: to the end of the source
  std::string size = "512x512";
  std::string gpu;
  AutoOptions automatic;
  SceneOptions scene;

  // These add options to a command, and write into this object, which must not move until the parser is done.

  /// Which files, and which volumes of the input.
  void add_files_to(CLI::App& command);
  /// --size and the view, but not the scene.
  void add_picture_to(CLI::App& command);
};

}  // namespace fanlight
