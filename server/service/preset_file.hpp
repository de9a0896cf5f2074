// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "server/service/saved_file.hpp"
#include "server/state/preset_store.hpp"

namespace fanlight {

/// The file in which presets are kept. Server thread only.
class PresetFile {
 public:
  /// `path` empty: presets are kept until the end only. `presets` must outlive this object, and no work may
  /// run after its end.
  PresetFile(std::filesystem::path path, PresetStore& presets, Executor executor);

  /// Reads the presets. A file that cannot be read, or not whole, is copied aside before anything replaces
  /// it.
  void load();

  /// The presets have changed: writes them soon.
  void presets_changed() {
    if (!path_.empty()) file_.changed();
  }

  /// Writes at once what is not written yet: the server ends.
  void finish() { file_.finish(); }

 private:
  std::filesystem::path path_;
  PresetStore& presets_;
  SavedFile file_;
};

}  // namespace fanlight
