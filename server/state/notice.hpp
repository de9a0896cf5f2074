// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// States that sessions are notified of, in the order in which a session sends them. A new one takes a row
/// here and a case in StreamSession::notice_message().
enum class Notice : std::uint8_t {
  kControl,       ///< another session holds control, or none
  kScene,         ///< the scene of the main view
  kView,          ///< the scene of the session's private view, or the end of that view
  kProbe,         ///< the state of the probe
  kLiveness,      ///< whether the picture is live, and why not
  kRecording,     ///< the state of the recorder
  kReplay,        ///< the state of the player of a recording
  kCine,          ///< which of the last volumes is shown
  kPresets,       ///< a preset was saved or removed
  kMeasurements,  ///< a measurement was kept, changed or removed
  kRelay,         ///< whether pictures are sent to an RTP receiver
  kStatistics,    ///< counters, once a second
};
inline constexpr std::uint8_t kNotices = static_cast<std::uint8_t>(Notice::kStatistics) + 1;

}  // namespace fanlight
