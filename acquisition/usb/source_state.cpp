// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/source_state.hpp"

#include <array>

namespace fanlight {

namespace {

struct Transition {
  SourceState from;
  SourceEvent event;
  SourceState to;
};

constexpr std::array kTransitions = {
    Transition{SourceState::kWaiting, SourceEvent::kProbeOpened, SourceState::kStarting},
    Transition{SourceState::kStarting, SourceEvent::kStarted, SourceState::kStreaming},
    Transition{SourceState::kStarting, SourceEvent::kProbeLost, SourceState::kWaiting},
    Transition{SourceState::kStreaming, SourceEvent::kReadFailed, SourceState::kRepairing},
    Transition{SourceState::kStreaming, SourceEvent::kSilent, SourceState::kRestarting},
    Transition{SourceState::kRepairing, SourceEvent::kRepaired, SourceState::kStreaming},
    Transition{SourceState::kRepairing, SourceEvent::kRepairedTooOften, SourceState::kResetting},
    Transition{SourceState::kRepairing, SourceEvent::kProbeLost, SourceState::kWaiting},
    Transition{SourceState::kRestarting, SourceEvent::kStarted, SourceState::kStreaming},
    Transition{SourceState::kRestarting, SourceEvent::kRepairedTooOften, SourceState::kResetting},
    Transition{SourceState::kRestarting, SourceEvent::kProbeLost, SourceState::kWaiting},
    Transition{SourceState::kResetting, SourceEvent::kProbeLost, SourceState::kWaiting},
};

}  // namespace

SourceState next_state(SourceState state, SourceEvent event) {
  if (event == SourceEvent::kStop) return SourceState::kStopped;
  for (const Transition& transition : kTransitions) {
    if (transition.from == state && transition.event == event) return transition.to;
  }
  return state;
}

}  // namespace fanlight
