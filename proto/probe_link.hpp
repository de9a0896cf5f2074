#pragma once

#include <cstdint>
#include <string>

#include "proto/counter.hpp"
#include "proto/doorbell.hpp"
#include "proto/mailbox.hpp"
#include "proto/probe_protocol.hpp"

namespace fanlight {

/// What somebody wants a probe to be set to. Numbered from 1, so that an answer can name it.
struct ProbeOrder {
  std::uint64_t number = 0;
  probe::Settings settings;
};

/// A probe as it stands, for those who watch.
struct ProbeStatus {
  enum class State : std::uint8_t {
    kAbsent,     ///< the source is no probe
    kStreaming,  ///< it is there and sends, or is about to
    kLost,       ///< it is gone; it will be taken again when it comes back
  };
  State state = State::kAbsent;
  std::uint64_t times_lost = 0;
  probe::Identity identity;
  probe::Capabilities capabilities;
  FanGeometry geometry;              ///< of the frames that come now
  probe::Settings settings;          ///< in force, or will be with the next sweep; as the probe answered
  std::uint64_t order_answered = 0;  ///< the newest order that was carried out or refused
  std::string trouble;               ///< why a probe that is there is not read; empty without
  std::string refusal;               ///< why that order was refused; empty where it was carried out
};

/// What the acquisition thread and the server thread share about a USB probe. Each mailbox has one writer:
/// orders the server, status the acquisition thread, which looks for orders several times a second.
struct ProbeLink {
  /// Both must outlive the link; `server_bell` is rung with each change of status.
  ProbeLink(Doorbell& acquisition_bell, Doorbell& server_bell)
      : orders(acquisition_bell), status(server_bell) {}

  ProbeCounters counters;
  Mailbox<ProbeOrder> orders;
  Mailbox<ProbeStatus> status;
};

}  // namespace fanlight
