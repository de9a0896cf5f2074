// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "server/metrics/picture_times.hpp"
#include "server/metrics/server_counters.hpp"
#include "server/state/picture_liveness.hpp"
#include "server/state/probe_proxy.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/state/replay_proxy.hpp"
#include "server/state/scene_store.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// What the metrics are read from.
struct MetricsSources {
  const PipelineCounters& pipeline;
  const ServerCounters& counters;
  const ProbeProxy& probe;
  const PictureLiveness& liveness;
  const PictureTimes& times;
  const RecordingProxy& recording;
  const ReplayProxy& replay;
  const PictureHub& hub;
  const SceneStore& scene_store;
};

/// All counters and values in the text format of Prometheus.
std::string metrics_text(const MetricsSources& sources);

}  // namespace fanlight
