// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/source/frame_source.hpp"
#include "acquisition/usb/usb_address.hpp"
#include "acquisition/usb/usb_probe.hpp"
#include "proto/exchange/probe_link.hpp"

namespace fanlight {

/// Requested settings of a probe before its first frame; absent: as the probe has it.
struct ProbeStartSettings {
  std::optional<double> sweep_deg;
  std::optional<std::uint32_t> frames_a_volume;
  std::optional<double> depth_mm;
};

/// Negotiates with a probe and keeps the result: identity, capabilities, geometry and settings. Publishes
/// them as ProbeStatus. Requests block for up to 500 ms each (UsbProbe). One thread.
class ProbeNegotiation {
 public:
  /// `link` must outlive it.
  ProbeNegotiation(const UsbAddress& address, ProbeLink& link) : name_(address.text()), link_(link) {}

  const SourceDescription& description() const { return description_; }
  /// Counts changes of geometry; only grows, also when another probe follows.
  std::uint32_t geometry_revision() const { return geometry_revision_; }

  /// Reads the whole description of a probe that was just opened, and applies the settings in force before a
  /// loss; settings that it refuses stay as the probe has them. Errors: as of UsbProbe, kBadInput, and
  /// kUnsupported for a probe that does not fit the first one.
  Result<void> negotiate(UsbProbe& probe);
  /// Applies the settings of the configuration. kInvalidArgument where the probe refuses one.
  Result<void> apply_start_settings(UsbProbe& probe, const ProbeStartSettings& asked);
  /// Carries out the newest order of the server, if there is one, and publishes the answer. `probe` may be
  /// nullptr: the order is then refused.
  void answer_order(UsbProbe* probe);

  /// Whether the geometry of a frame is known; asks the probe for a new one, at most every 50 ms.
  bool knows_geometry_of(const probe::FrameHeader& header, UsbProbe& probe);

  /// A plugged-in probe cannot be used; published if the text changed.
  void report_trouble(const std::string& trouble);
  /// A frame arrived: publishes kStreaming if the state was another one.
  void report_frame();
  /// Whether the probe sent a frame since it was opened.
  bool had_frames() const { return status_.state == ProbeStatus::State::kStreaming; }
  /// The probe was closed: publishes kLost if had_frames().
  void report_loss();

 private:
  Result<void> describe(UsbProbe& probe);
  void describe_source(const probe::Capabilities& capabilities, const FanGeometry& fan);
  Result<void> apply(UsbProbe& probe, const probe::Settings& wanted);
  void use_settings(const probe::Settings& settings);
  void publish(ProbeStatus::State state);

  std::string name_;
  ProbeLink& link_;
  SourceDescription description_;
  ProbeStatus status_;
  std::optional<probe::Settings> wanted_;  // in force after the last order; applied again after a loss
  probe::Geometry geometry_;               // with the probe's own revision
  std::uint32_t geometry_revision_ = 0;
  std::int64_t last_geometry_request_ns_ = 0;
};

}  // namespace fanlight
