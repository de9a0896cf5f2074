// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/model/picture_size_text.hpp"
#include "proto/model/scene.hpp"
#include "renderer/parameters/view_frame.hpp"

namespace fanlight {

/// The command line options of the scene: one for each field of the scene table, with the name of the field
/// (--detector.threshold 30, --mode volume), --preset and --look.
class SceneOptions {
 public:
  /// The options write into this object, which must not move until the parser is done.
  void add_to(CLI::App& command);

  /// Whether an option says what to look at: the mode, the camera, or where the rays begin and end.
  bool choose_view() const;

  /// The fields that options were given for.
  std::vector<const SceneField*> given() const;

  /// The scene with the given options applied: the preset first, then the look, then the fields. Errors: a
  /// value that is not allowed, a preset that is not known or cannot be read.
  Result<Scene> applied_to(const Scene& unchanged) const;

 private:
  Result<Scene> with_preset(Scene scene) const;

  std::string preset_;
  std::string look_;
  std::deque<std::pair<const SceneField*, std::string>> given_;  // a deque: its elements do not move
};

}  // namespace fanlight
