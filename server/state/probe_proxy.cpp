// SPDX-License-Identifier: Apache-2.0
#include "server/state/probe_proxy.hpp"

#include <fmt/format.h>

#include <cmath>

namespace fanlight {

namespace {

void set_range(v1::ProbeStatus::Range& to, double minimum, double maximum) {
  to.set_minimum(minimum);
  to.set_maximum(maximum);
}

}  // namespace

bool ProbeProxy::update() {
  const ProbeStatus* const newest = link_.status.newest();
  if (newest == nullptr) return false;
  status_ = *newest;
  return true;
}

Result<std::uint64_t> ProbeProxy::order(const v1::ProbeSettings& change) {
  if (control_ == ProbeControl::kNobody) {
    return Error{
        ErrorCode::kInvalidArgument,
        "the probe may not be set over the network, expected a server with --probe-control everyone"};
  }
  if (status_.state == ProbeStatus::State::kAbsent) {
    return Error{ErrorCode::kUnavailable,
                 "there is no probe to set, expected a source such as usb:1209:0001"};
  }
  // A change is relative to the orders that are not answered yet.
  const bool pending = last_order_.number > status_.order_answered;
  probe::Settings wanted = pending ? last_order_.settings : status_.settings;
  if (change.has_sweep_deg()) wanted.sweep_deg = change.sweep_deg();
  if (change.has_frames_a_volume()) wanted.frames_a_volume = change.frames_a_volume();
  if (change.has_depth_mm()) wanted.depth_mm = change.depth_mm();
  if (!std::isfinite(wanted.sweep_deg) || !std::isfinite(wanted.depth_mm)) {
    return Error{ErrorCode::kInvalidArgument, "a setting of the probe is no finite number, expected one"};
  }
  last_order_ = {.number = last_order_.number + 1, .settings = wanted};
  link_.orders.draft() = last_order_;
  link_.orders.publish();
  return last_order_.number;
}

v1::ProbeStatus ProbeProxy::message() const {
  v1::ProbeStatus message;
  message.set_state(static_cast<v1::ProbeStatus::State>(status_.state));
  message.set_times_lost(status_.times_lost);
  message.set_model(status_.identity.model);
  message.set_serial(status_.identity.serial);
  message.set_firmware(status_.identity.firmware);
  message.set_trouble(status_.trouble);
  *message.mutable_settings() = settings_message(status_.settings);
  const probe::Capabilities& offered = status_.capabilities;
  set_range(*message.mutable_sweep_deg(), offered.least_sweep_deg, offered.most_sweep_deg);
  set_range(*message.mutable_frames_a_volume(), offered.least_frames, offered.most_frames);
  set_range(*message.mutable_depth_mm(), offered.least_depth_mm, offered.most_depth_mm);
  message.set_may_be_set(control_ == ProbeControl::kEveryone && status_.state != ProbeStatus::State::kAbsent);
  return message;
}

std::string ProbeProxy::sentence() const {
  const probe::Settings& settings = status_.settings;
  if (status_.state == ProbeStatus::State::kAbsent)  // OpenIGTLink in its place, which has no settings
    return fmt::format("{} of {} is connected", status_.identity.model, status_.identity.serial);
  if (lost()) return fmt::format("the probe {} {} is lost", status_.identity.model, status_.identity.serial);
  return fmt::format("the probe {} {} streams: {} deg, {} frames a volume, {} mm", status_.identity.model,
                     status_.identity.serial, settings.sweep_deg, settings.frames_a_volume,
                     settings.depth_mm);
}

v1::ProbeSettings settings_message(const probe::Settings& settings) {
  v1::ProbeSettings message;
  message.set_sweep_deg(settings.sweep_deg);
  message.set_frames_a_volume(settings.frames_a_volume);
  message.set_depth_mm(settings.depth_mm);
  return message;
}

}  // namespace fanlight
