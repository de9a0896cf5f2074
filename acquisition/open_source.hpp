#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "acquisition/frame_source.hpp"
#include "acquisition/replay_source.hpp"
#include "acquisition/usb_source.hpp"

namespace fanlight {

/// How a source is to be played; what the text that names it does not say.
struct SourceOptions {
  std::filesystem::path geometry_path;  ///< of a recording; empty: see RecordingGeometry
  double speed = 1;                     ///< of a recording: 1 as recorded, 0.01 to 1000
  bool as_fast_as_taken = false;        ///< no pace: capture times are simulated, and no frame is lost
  ReplaySource::Ending ending = ReplaySource::Ending::kOnce;  ///< of a recording; the others never end
  UsbSource::Settings probe_settings;                         ///< of a USB probe
  double wait_for_probe_s = 5;                                ///< see UsbSource::Config
};

/// The source that a text names, open: "phantom:" and its options (PhantomSource::parse), "replay:PATH" or
/// the PATH of a recording alone, or "usb:VENDOR:PRODUCT[:SERIAL]" (UsbAddress). Reads files, and waits for
/// the probe; errors as the sources' own. `link` must outlive the source; a probe alone uses it.
Result<std::unique_ptr<FrameSource>> open_source(std::string_view text, const SourceOptions& options,
                                                 ProbeLink& link);

}  // namespace fanlight
