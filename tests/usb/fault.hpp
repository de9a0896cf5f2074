// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace fanlight::test {

/// Faults of the emulated probe.
enum class FaultKind : std::uint8_t {
  // Of one frame: applied to the next frame on the pipe.
  kDrop,          ///< not sent: a gap in the sequence
  kInvalid,       ///< flagged as invalid
  kMisfit,        ///< its header has an unknown geometry revision
  kDamage,        ///< one bit of its pixels is wrong
  kDamageHeader,  ///< one bit of its header is wrong
  kCut,           ///< the frame and its transfer end in the middle of its pixels
  kRepeat,        ///< sent twice
  kSwap,          ///< sent after its successor
  kNoise,         ///< preceded by Fault::bytes random bytes in the same transfer
  // Of the stream.
  kGeometry,  ///< from the next captured frame on, the depth is three quarters of the full one, or the full
              ///< one again
  kRestart,   ///< the next captured frame is frame 0 of sweep 0, without notice
  kSilent,    ///< nothing is sent for Fault::duration_ns; frames are captured and lost
  kRandom,    ///< random bytes without an end of transfer instead of all frames, until a start or a new plug
  // Of the bus.
  kStall,         ///< the bulk endpoint halts in its next transfer with data, until CLEAR_HALT; data and the
                  ///< rest of the frame are lost
  kError,         ///< the next bulk transfer with data fails with EPROTO; its data is lost
  kOverflow,      ///< the same with EOVERFLOW
  kLateIdentity,  ///< the next identity request is never answered
  kMute,          ///< no control request is answered for Fault::duration_ns
  kUnplug,        ///< with pending transfers
  kReplug,        ///< under a new device number; a plugged-in probe is unplugged first
};

struct Fault {
  FaultKind kind = FaultKind::kDrop;
  std::uint32_t bytes = 0;       ///< of kNoise
  std::int64_t duration_ns = 0;  ///< of kSilent and kMute

  bool operator==(const Fault&) const = default;
};

/// Word of a fault in a FaultScript, and its argument.
struct FaultWord {
  enum class Argument : std::uint8_t { kNone, kBytes, kDuration };

  FaultKind kind;
  std::string_view word;
  Argument argument = Argument::kNone;
};
/// All words, in the order of FaultKind.
std::span<const FaultWord> fault_words();

}  // namespace fanlight::test
