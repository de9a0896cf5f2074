#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace fanlight::test {

/// What can go wrong with the emulated probe.
enum class FaultKind : std::uint8_t {
  // Of one frame: each waits for the next frame that goes on the pipe.
  kDrop,          ///< it is not sent: a gap in the sequence
  kInvalid,       ///< it is flagged as of no use
  kMisfit,        ///< its header names a geometry that the probe does not have
  kDamage,        ///< one bit of its pixels is wrong
  kDamageHeader,  ///< one bit of its header is wrong
  kCut,           ///< it ends, and its transfer with it, in the midst of its pixels
  kRepeat,        ///< it comes twice
  kSwap,          ///< it comes after its successor
  kNoise,         ///< Fault::bytes random ones come before it, in the same transfer
  // Of the stream.
  kGeometry,  ///< from the next frame taken the depth is three quarters of the full one, or the full one
              ///< again
  kRestart,   ///< the next frame taken is frame 0 of sweep 0 again, without a word
  kSilent,    ///< nothing is sent for Fault::duration_ns; frames are taken meanwhile, and lost
  kRandom,    ///< random bytes without an end of transfer in place of all frames, until start or a new plug
  // Of the bus.
  kStall,         ///< the bulk endpoint halts in its next transfer with data, until CLEAR_HALT; data and the
                  ///< rest of the frame are lost
  kError,         ///< the next bulk transfer with data fails with EPROTO, and the data is lost
  kOverflow,      ///< the same with EOVERFLOW
  kLateIdentity,  ///< the next request for the identity is never answered
  kMute,          ///< no control request is answered for Fault::duration_ns
  kUnplug,        ///< with whatever is in flight
  kReplug,        ///< under a new device number; a probe that is plugged in is unplugged first
};

struct Fault {
  FaultKind kind = FaultKind::kDrop;
  std::uint32_t bytes = 0;       ///< of kNoise
  std::int64_t duration_ns = 0;  ///< of kSilent and kMute

  bool operator==(const Fault&) const = default;
};

/// A fault's word in a FaultScript, and what comes after it.
struct FaultWord {
  enum class Argument : std::uint8_t { kNone, kBytes, kDuration };

  FaultKind kind;
  std::string_view word;
  Argument argument = Argument::kNone;
};
/// All of them, in the order of FaultKind.
std::span<const FaultWord> fault_words();

}  // namespace fanlight::test
