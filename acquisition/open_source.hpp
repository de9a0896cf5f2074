#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "acquisition/frame_source.hpp"
#include "acquisition/replay_source.hpp"

namespace fanlight {

/// How a source is to be played; what the text that names it does not say.
struct SourceOptions {
  std::filesystem::path geometry_path;  ///< of a recording; empty: see RecordingGeometry
  double speed = 1;                     ///< of a recording: 1 as recorded, 0.01 to 1000
  bool as_fast_as_taken = false;        ///< no pace: capture times are simulated, and no frame is lost
  ReplaySource::Ending ending = ReplaySource::Ending::kOnce;  ///< of a recording; the phantom never ends
};

/// The source that a text names, open: "phantom:" and its options (PhantomSource::parse), "replay:PATH", or
/// the PATH of a recording alone. Reads files; errors as the sources' own.
Result<std::unique_ptr<FrameSource>> open_source(std::string_view text, const SourceOptions& options);

}  // namespace fanlight
