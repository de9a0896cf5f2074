// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/model/frame_origin.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "proto/model/probe_protocol.hpp"

namespace fanlight {

/// Settings requested by the server. Numbered from 1, so that an answer can refer to it.
struct ProbeOrder {
  std::uint64_t number = 0;
  probe::Settings settings;
};

/// Present state of a probe.
struct ProbeStatus {
  enum class State : std::uint8_t {
    kAbsent,     ///< the source is no probe
    kStreaming,  ///< the probe is open and sends, or is about to
    kLost,       ///< the probe is gone; it is opened again when it returns
  };
  State state = State::kAbsent;
  std::uint64_t times_lost = 0;
  probe::Identity identity;
  probe::Capabilities capabilities;
  FanGeometry geometry;               ///< of the present frames
  probe::Settings settings;           ///< as reported by the probe; in force, or from the next sweep on
  std::uint64_t order_answered = 0;   ///< number of the newest order that was executed or refused
  std::optional<FrameOrigin> origin;  ///< of the frames, where their sender says it
  std::string trouble;                ///< why a plugged-in probe cannot be read; empty: no trouble
  std::string refusal;                ///< why that order was refused; empty: it was executed
};

/// Data about a USB probe, or an OpenIGTLink server in its place, shared by the acquisition thread and the
/// server thread. Each mailbox has one writer: the server writes orders, the acquisition thread status; it
/// polls for orders several times a second.
struct ProbeLink {
  /// Both must outlive the link; `server_bell` rings with each change of the status.
  ProbeLink(Doorbell& acquisition_bell, Doorbell& server_bell)
      : orders(acquisition_bell), status(server_bell) {}

  ProbeCounters counters;
  IgtlCounters igtl;
  Mailbox<ProbeOrder> orders;
  Mailbox<ProbeStatus> status;
};

}  // namespace fanlight
