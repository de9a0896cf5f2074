// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/probe_negotiation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/source/frame_source.hpp"
#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

// Least time between two requests for a geometry: a probe whose frames name an unknown one is not asked with
// every frame.
constexpr std::int64_t kGeometryRequestNs = 50'000'000;

// Largest memory of one volume; the ring has several.
constexpr std::uint64_t kMostVolumeBytes = 1 << 30;

Result<void> check_setting(const char* name, double value, double least, double most, const char* unit) {
  if (value >= least && value <= most) return {};
  return Error{ErrorCode::kInvalidArgument, fmt::format("the probe's {} was to be {}{}, expected {} to {}{}",
                                                        name, value, unit, least, most, unit)};
}

/// Number of frames that a volume must be able to hold. A probe that does not count its volumes may reverse
/// late, and until the reversal is detected its frames are added to the sweep before. Limited by memory,
/// whatever the probe offers.
std::uint32_t volume_capacity(const probe::Capabilities& offered) {
  const std::uint64_t frame_bytes = std::uint64_t{offered.most_columns} * offered.most_rows;
  const std::uint32_t wanted =
      offered.counts_volumes ? offered.most_frames : offered.most_frames + offered.most_frames / 4 + 8;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, kMostVolumeBytes / frame_bytes));
}

/// kInvalidArgument, with the range, for the first setting that the probe does not offer.
Result<void> check_settings(const probe::Settings& settings, const probe::Capabilities& offered) {
  auto outcome =
      check_setting("sweep", settings.sweep_deg, offered.least_sweep_deg, offered.most_sweep_deg, " deg");
  if (outcome) {
    outcome = check_setting("number of frames a volume", settings.frames_a_volume, offered.least_frames,
                            offered.most_frames, "");
  }
  if (outcome) {
    outcome = check_setting("depth", settings.depth_mm, offered.least_depth_mm, offered.most_depth_mm, " mm");
  }
  return outcome;
}

/// Whether a later probe fits the ring and the description that were made for the first one; kUnsupported if
/// not.
Result<void> check_fit(const probe::Capabilities& offered, const probe::Settings& settings,
                       const FanGeometry& fan, const SourceDescription& made_for) {
  if (offered.counts_volumes == made_for.counts_volumes &&
      settings.frames_a_volume <= made_for.frames_per_volume &&
      fan.frame_bytes() <= made_for.largest_frame_bytes) {
    return {};
  }
  return Error{ErrorCode::kUnsupported,
               fmt::format("the connected probe sends {} frames a volume of {} bytes and {} its volumes; "
                           "expected at most {} of {} bytes and one that {}, or a restart of Fanlight",
                           settings.frames_a_volume, fan.frame_bytes(),
                           offered.counts_volumes ? "counts" : "does not count", made_for.frames_per_volume,
                           made_for.largest_frame_bytes, made_for.counts_volumes ? "does" : "does not")};
}

}  // namespace

Result<void> ProbeNegotiation::negotiate(UsbProbe& probe) {
  auto described = describe(probe);
  if (!described || !wanted_) return described;
  (void)apply(probe, *wanted_);
  return describe(probe);
}

Result<void> ProbeNegotiation::apply_start_settings(UsbProbe& probe, const ProbeStartSettings& asked) {
  if (!asked.sweep_deg && !asked.frames_a_volume && !asked.depth_mm) return {};
  const probe::Settings& present = status_.settings;
  const probe::Settings wanted{.sweep_deg = asked.sweep_deg.value_or(present.sweep_deg),
                               .frames_a_volume = asked.frames_a_volume.value_or(present.frames_a_volume),
                               .depth_mm = asked.depth_mm.value_or(present.depth_mm)};
  if (auto applied = apply(probe, wanted); !applied) return applied;
  return describe(probe);
}

Result<void> ProbeNegotiation::describe(UsbProbe& probe) {
  auto identity = probe.identity();
  if (!identity) return identity.error();
  auto capabilities = probe.capabilities();
  if (!capabilities) return capabilities.error();
  const auto settings = probe.settings();
  if (!settings) return settings.error();
  const auto geometry = probe.geometry();
  if (!geometry) return geometry.error();
  if (auto checked = check_settings(*settings, *capabilities); !checked) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("the probe is set to what it does not offer: {}", checked.error().message)};
  }
  describe_source(*capabilities, geometry->fan);
  // The ring's memory and the way in which sweeps are separated were fixed with the first probe.
  capabilities->most_frames = std::min(capabilities->most_frames, description_.frames_per_volume);
  if (auto fits = check_fit(*capabilities, *settings, geometry->fan, description_); !fits) return fits;
  geometry_ = *geometry;
  description_.geometry = geometry->fan;
  status_.identity = *std::move(identity);
  status_.capabilities = *capabilities;
  use_settings(*settings);
  return {};
}

void ProbeNegotiation::describe_source(const probe::Capabilities& capabilities, const FanGeometry& fan) {
  if (description_.name.empty()) {
    description_.name = name_;
    description_.counts_volumes = capabilities.counts_volumes;
    description_.largest_frame_bytes = std::uint64_t{capabilities.most_columns} * capabilities.most_rows;
    description_.frames_per_volume = volume_capacity(capabilities);
  } else if (fan != description_.geometry) {
    ++geometry_revision_;
  }
}

void ProbeNegotiation::use_settings(const probe::Settings& settings) {
  status_.settings = settings;
  description_.usual_frames = settings.frames_a_volume;
  description_.last_angle_rad = radians(settings.sweep_deg / 2);
  description_.first_angle_rad = -description_.last_angle_rad;
}

void ProbeNegotiation::answer_order(UsbProbe* probe) {
  const ProbeOrder* const order = link_.orders.newest();
  if (order == nullptr) return;
  const Result<void> applied =
      probe != nullptr
          ? apply(*probe, order->settings)
          : Result<void>(Error{ErrorCode::kUnavailable, "the probe is not connected, expected one"});
  status_.order_answered = order->number;
  status_.refusal = applied ? std::string() : applied.error().message;
  publish(status_.state);
}

Result<void> ProbeNegotiation::apply(UsbProbe& probe, const probe::Settings& wanted) {
  using probe::Request;
  const probe::Settings& present = status_.settings;
  auto outcome = check_settings(wanted, status_.capabilities);
  if (outcome && wanted.sweep_deg != present.sweep_deg) {
    outcome = probe.set(Request::kSetSweep, static_cast<std::uint32_t>(std::lround(wanted.sweep_deg * 1e6)));
  }
  if (outcome && wanted.frames_a_volume != present.frames_a_volume) {
    outcome = probe.set(Request::kSetFrames, wanted.frames_a_volume);
  }
  if (outcome && wanted.depth_mm != present.depth_mm) {
    outcome = probe.set(Request::kSetDepth, static_cast<std::uint32_t>(std::lround(wanted.depth_mm * 1e3)));
  }
  // Read back even after a refusal: the settings that the probe took before it stay in force.
  const auto in_force = probe.settings();
  if (in_force) {
    use_settings(*in_force);
    wanted_ = *in_force;
  } else if (outcome) {
    outcome = in_force.error();
  }
  (outcome ? link_.counters.settings_taken : link_.counters.settings_refused).add();
  return outcome;
}

bool ProbeNegotiation::knows_geometry_of(const probe::FrameHeader& header, UsbProbe& probe) {
  if (header.geometry_revision == geometry_.revision) return true;
  if (now_ns() - last_geometry_request_ns_ < kGeometryRequestNs) return false;
  const auto geometry = probe.geometry();
  last_geometry_request_ns_ = now_ns();
  if (!geometry) return false;
  geometry_ = *geometry;
  if (geometry_.fan != description_.geometry) {
    ++geometry_revision_;
    description_.geometry = geometry_.fan;
    publish(status_.state);
  }
  return header.geometry_revision == geometry_.revision;
}

void ProbeNegotiation::report_trouble(const std::string& trouble) {
  if (status_.trouble == trouble) return;
  status_.trouble = trouble;
  if (status_.state != ProbeStatus::State::kAbsent) publish(status_.state);
}

void ProbeNegotiation::report_frame() {
  if (had_frames()) return;
  status_.trouble.clear();
  publish(ProbeStatus::State::kStreaming);
}

void ProbeNegotiation::report_loss() {
  if (!had_frames()) return;
  ++status_.times_lost;
  publish(ProbeStatus::State::kLost);
}

void ProbeNegotiation::publish(ProbeStatus::State state) {
  status_.state = state;
  status_.geometry = description_.geometry;
  link_.status.draft() = status_;
  link_.status.publish();
}

}  // namespace fanlight
