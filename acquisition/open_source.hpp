// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>

#include "acquisition/igtl/igtl_source.hpp"
#include "acquisition/replay/replay_source.hpp"
#include "acquisition/source/frame_source.hpp"
#include "acquisition/usb/usb_source.hpp"

namespace fanlight {

/// How a source without a device keeps time. A probe or scanner is always in real time.
enum class SourcePace : std::uint8_t {
  /// As a probe: frames are due at their times, and what comes too late is lost.
  kRealTime,
  kPatient,        ///< the same, but frames wait for a slow caller, and none is lost
  kAsFastAsTaken,  ///< no pacing: capture times are simulated, and no frame is lost
};

/// Options of a source that are not part of its name.
struct SourceOptions {
  std::filesystem::path geometry_path;  ///< of a recording or of OpenIGTLink; empty: see RecordingGeometry
  double speed = 1;                     ///< of a recording: 1 as recorded; 0.01 to 1000
  SourcePace pace = SourcePace::kRealTime;  ///< of a recording or the simulated probe
  /// In real time too, a simulated probe of limited volumes loses no frame: the last volume may be all that
  /// there is to show.
  bool ends_whole = false;
  ReplayEnding ending = ReplayEnding::kOnce;  ///< of a recording; other sources never end
  double from_s = 0;                          ///< of a recording: where it begins
  bool paused = false;                        ///< of a recording: shows its first sweep and waits for orders
  UsbSource::Settings probe_settings;         ///< of a USB probe
  double wait_for_probe_s = 5;                ///< see UsbSource::Config and IgtlSource::Config
  std::function<bool()> stopped{};            ///< of OpenIGTLink: see IgtlSource::Config
};

/// Opens the source that a text names: "phantom:" (usual_phantom()) with options, "replay:PATH" or the
/// PATH of a recording alone, "usb:VENDOR:PRODUCT[:SERIAL]" (UsbAddress), or "igtl:HOST[:PORT]"
/// (IgtlAddress). Reads files, and blocks until a probe is found, or the geometry of a scanner's images;
/// errors as of the source's own create(). The links must outlive the source. A USB probe and OpenIGTLink use
/// `probe`, a recording `replay`; nullptr: the recording is not controlled.
Result<std::unique_ptr<FrameSource>> open_source(std::string_view text, const SourceOptions& options,
                                                 ProbeLink& probe, ReplayLink* replay = nullptr);

}  // namespace fanlight
