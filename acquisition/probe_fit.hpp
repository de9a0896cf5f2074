#pragma once

#include <cstdint>

#include "acquisition/frame_source.hpp"
#include "proto/probe_protocol.hpp"

// What of a probe's offers and settings Fanlight can take. Any thread.
namespace fanlight {

/// Frames that a volume must be able to hold. A probe that does not count its volumes may turn late, and
/// until a turn is recognised the frames after it are put with those before. Bounded by memory, whatever a
/// probe offers.
std::uint32_t volume_capacity(const probe::Capabilities& offered);

/// kInvalidArgument, with the range, for the first setting that is not offered.
Result<void> check_settings(const probe::Settings& settings, const probe::Capabilities& offered);

/// Whether a probe that comes later can be read with what was made for the first; kUnsupported if not.
Result<void> check_fit(const probe::Capabilities& offered, const probe::Settings& settings,
                       const FanGeometry& fan, const SourceDescription& made_for);

}  // namespace fanlight
