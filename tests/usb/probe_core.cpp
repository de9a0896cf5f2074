// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/probe_core.hpp"

namespace fanlight::test {

void ProbeCore::carry_out(const Fault& fault, std::int64_t now_ns) {
  ++carried_out[static_cast<std::size_t>(fault.kind)];
  switch (fault.kind) {
    case FaultKind::kStall:
    case FaultKind::kError:
    case FaultKind::kOverflow:
      of_next_transfer = fault.kind;
      break;
    case FaultKind::kLateIdentity:
      late_identity = true;
      break;
    case FaultKind::kMute:
      mute_until_ns = now_ns + fault.duration_ns;
      break;
    case FaultKind::kUnplug:
    case FaultKind::kReplug:
      plug_wish = fault.kind;
      changed.notify_all();
      break;
    default:
      model->inject(fault, now_ns);
  }
}

}  // namespace fanlight::test
