// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// States of a UsbSource.
enum class SourceState : std::uint8_t {
  kWaiting,     ///< no probe is open: the buses are searched for one
  kStarting,    ///< a probe is open and described; its stream is started by the next call for a frame
  kStreaming,   ///< reads are pending
  kRepairing,   ///< a read failed: all reads are being cancelled, then the halt is cleared and they start
                ///< again
  kRestarting,  ///< the probe was silent: the stream is stopped and started
  kResetting,   ///< repairs did not help: the probe is reset and closed
  kStopped,     ///< the source is being destroyed
};

/// Events that may change the state of a UsbSource.
enum class SourceEvent : std::uint8_t {
  kProbeOpened,       ///< a probe was opened and its answers fit
  kStarted,           ///< the probe streams, and reads are pending
  kReadFailed,        ///< a read ended with an error, or the system refused all reads
  kSilent,            ///< no bytes, or bytes without a frame, for SilenceWatch::kSilenceNs
  kRepaired,          ///< the halt is cleared, and reads are pending again
  kRepairedTooOften,  ///< repaired or restarted, but RepairLimit is exceeded
  kProbeLost,         ///< the probe is gone, does not answer, or was reset
  kStop,
};

/// The only table of transitions. Events that a state does not expect leave it unchanged.
///
/// ```
/// kWaiting --kProbeOpened--> kStarting --kStarted--> kStreaming
/// kStreaming --kReadFailed--> kRepairing --kRepaired--> kStreaming
/// kStreaming --kSilent--> kRestarting --kStarted--> kStreaming
/// kRepairing, kRestarting --kRepairedTooOften--> kResetting
/// kStarting, kRepairing, kRestarting, kResetting --kProbeLost--> kWaiting
/// any --kStop--> kStopped
/// ```
SourceState next_state(SourceState state, SourceEvent event);

}  // namespace fanlight
