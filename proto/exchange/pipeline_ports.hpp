// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "proto/exchange/frame_tap.hpp"
#include "proto/exchange/probe_link.hpp"
#include "proto/exchange/recording_link.hpp"
#include "proto/exchange/render_link.hpp"
#include "proto/exchange/replay_link.hpp"
#include "proto/model/pipeline_counters.hpp"

namespace fanlight {

/// The server thread's ends of all that it exchanges with the acquisition thread, the render thread and the
/// recorder. All that the server reads, and a change of source_state, ring the bell RenderLink::to_server.
/// All must outlive the server.
struct PipelinePorts {
  RenderLink& render;
  ProbeLink& probe;
  ReplayLink& replay;
  PipelineCounters counters;
  std::function<std::string()> source_state;  ///< "running", "ended", or why the source failed
  std::optional<RecordingLink> recording{};   ///< absent: nothing is recorded
  FrameTap* frames = nullptr;                 ///< of the source, for OpenIGTLink; null: none are sent
};

}  // namespace fanlight
