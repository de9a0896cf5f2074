// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/fault.hpp"

namespace fanlight::test {

std::span<const FaultWord> fault_words() {
  using Argument = FaultWord::Argument;
  static constexpr FaultWord kWords[] = {
      {FaultKind::kDrop, "drop"},
      {FaultKind::kInvalid, "invalid"},
      {FaultKind::kMisfit, "misfit"},
      {FaultKind::kDamage, "damage"},
      {FaultKind::kDamageHeader, "damage-header"},
      {FaultKind::kCut, "cut"},
      {FaultKind::kRepeat, "repeat"},
      {FaultKind::kSwap, "swap"},
      {FaultKind::kNoise, "noise", Argument::kBytes},
      {FaultKind::kGeometry, "geometry"},
      {FaultKind::kRestart, "restart"},
      {FaultKind::kSilent, "silent", Argument::kDuration},
      {FaultKind::kRandom, "random"},
      {FaultKind::kStall, "stall"},
      {FaultKind::kError, "error"},
      {FaultKind::kOverflow, "overflow"},
      {FaultKind::kLateIdentity, "late-identity"},
      {FaultKind::kMute, "mute", Argument::kDuration},
      {FaultKind::kUnplug, "unplug"},
      {FaultKind::kReplug, "replug"},
  };
  static_assert(std::size(kWords) == static_cast<std::size_t>(FaultKind::kReplug) + 1);
  return kWords;
}

}  // namespace fanlight::test
