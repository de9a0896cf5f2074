#pragma once

#include <CLI/App.hpp>
#include <deque>
#include <string>
#include <utility>

#include "proto/result.hpp"
#include "proto/scene.hpp"
#include "renderer/view.hpp"

namespace fanlight {

/// The scene on the command line: an option for each row of the scene table, under its own name
/// (--detector.threshold 30, --mode volume).
class SceneOptions {
 public:
  /// The options write into this object, which must stay where it is until the parser is done.
  void add_to(CLI::App& command);

  /// The scene with the options that were given, each checked.
  Result<Scene> applied_to(Scene scene) const;

 private:
  std::deque<std::pair<const SceneField*, std::string>> given_;  // a deque: its elements do not move
};

/// "512x512": width and height in pixels, 16 to 2048 each.
Result<PictureSize> parse_picture_size(const std::string& text);

}  // namespace fanlight
