// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "acquisition/source/frame_source.hpp"
#include "proto/model/probe_protocol.hpp"

// Checks which probes and settings Fanlight supports. Any thread.
namespace fanlight {

/// Number of frames that a volume must be able to hold. A probe that does not count its volumes may reverse
/// late, and until the reversal is detected its frames are added to the sweep before. Limited by memory,
/// whatever the probe offers.
std::uint32_t volume_capacity(const probe::Capabilities& offered);

/// kInvalidArgument, with the range, for the first setting that the probe does not offer.
Result<void> check_settings(const probe::Settings& settings, const probe::Capabilities& offered);

/// Whether a later probe fits the ring and the description that were made for the first one; kUnsupported if
/// not.
Result<void> check_fit(const probe::Capabilities& offered, const probe::Settings& settings,
                       const FanGeometry& fan, const SourceDescription& made_for);

}  // namespace fanlight
