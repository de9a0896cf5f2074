// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "server/state/preset_store.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// The file in which presets are kept. Written on a thread of the encoders, at most once at a time. Server
/// thread only.
class PresetFile {
 public:
  /// `path` empty: presets are kept until the end only. `presets` must outlive this object, and no work may
  /// run after its end.
  PresetFile(std::filesystem::path path, PresetStore& presets, Executor executor);

  /// Reads the presets. A file that cannot be read, or not whole, is copied aside before anything replaces
  /// it.
  void load();

  /// The presets have changed: writes them soon.
  void presets_changed();

  /// Writes at once what is not written yet: the server ends.
  void finish();

 private:
  void write();
  bool save(const std::string& text) const;

  std::filesystem::path path_;
  PresetStore& presets_;
  Executor executor_;
  bool writing_ = false;
  bool unwritten_ = false;  // they have changed since the last writing began, or it has failed
};

}  // namespace fanlight
