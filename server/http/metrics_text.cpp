// SPDX-License-Identifier: Apache-2.0
#include "server/http/metrics_text.hpp"

#include <fmt/format.h>
#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <vector>

namespace fanlight {

namespace {

prometheus::MetricFamily family(const std::string& name, const char* help, prometheus::MetricType type,
                                double value) {
  prometheus::ClientMetric metric;
  if (type == prometheus::MetricType::Counter) {
    metric.counter.value = value;
  } else {
    metric.gauge.value = value;
  }
  return {.name = name, .help = help, .type = type, .metric = {metric}};
}

}  // namespace

std::string metrics_text(const MetricsSources& sources) {
  std::vector<prometheus::MetricFamily> families;
  for (const NamedCount& count : named_counts(sources.pipeline, sources.counters)) {
    const bool total = count.kind == CountKind::kTotal;
    families.push_back(family(fmt::format("fanlight_{}{}", count.name, total ? "_total" : ""), count.help,
                              total ? prometheus::MetricType::Counter : prometheus::MetricType::Gauge,
                              static_cast<double>(count.value)));
  }
  for (const NamedValue& value : named_values(sources.pipeline)) {
    families.push_back(family(fmt::format("fanlight_{}", value.name), value.help,
                              prometheus::MetricType::Gauge, value.value));
  }
  families.push_back(family(
      "fanlight_probe_streaming", "1 while a probe streams, 0 while it is lost or there is none",
      prometheus::MetricType::Gauge, sources.probe.status().state == ProbeStatus::State::kStreaming ? 1 : 0));
  const PictureLiveness::Report& liveness = sources.liveness.report();
  families.push_back(family("fanlight_picture_live",
                            "1 while the main view shows what the probe sees now, 0 while its picture is old",
                            prometheus::MetricType::Gauge, liveness.live() ? 1 : 0));
  families.push_back(
      family("fanlight_picture_age_seconds",
             "From the capture of the newest picture's volume to now; -1 before the first picture",
             prometheus::MetricType::Gauge, liveness.age_s));
  families.push_back(family("fanlight_picture_resting",
                            "1 while nothing is rendered since nobody looks: the picture is then not live",
                            prometheus::MetricType::Gauge,
                            liveness.state == PictureLiveness::State::kResting ? 1 : 0));
  families.push_back(family("fanlight_replay", "1 while the source is a recording, 0 while it is live",
                            prometheus::MetricType::Gauge, sources.replay.is_replay() ? 1 : 0));
  const RecordingStatus& recording = sources.recording.status();
  families.push_back(
      family("fanlight_recording", "1 while frames are recorded, also to keep the last minutes; else 0",
             prometheus::MetricType::Gauge, recording.state == RecordingStatus::State::kRecording ? 1 : 0));
  families.push_back(family("fanlight_recording_halted", "1 while a recording waits for room on its disk",
                            prometheus::MetricType::Gauge,
                            recording.state == RecordingStatus::State::kNoRoom ? 1 : 0));
  families.push_back(family("fanlight_recording_frames_missed",
                            "Frames that the disk did not take in time, of the recording under way",
                            prometheus::MetricType::Gauge, static_cast<double>(recording.frames_missed)));
  families.push_back(family("fanlight_recordings_ended_total", "Recordings that have ended",
                            prometheus::MetricType::Counter, static_cast<double>(recording.finished)));
  families.push_back(family("fanlight_sessions", "Displays connected", prometheus::MetricType::Gauge,
                            static_cast<double>(sources.hub.subscriber_count())));
  families.push_back(family("fanlight_scene_revision", "Number of the scene in force",
                            prometheus::MetricType::Gauge,
                            static_cast<double>(sources.scene_store.in_force().revision)));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace fanlight
