// SPDX-License-Identifier: Apache-2.0
#include "server/http/metrics_text.hpp"

#include <fmt/format.h>
#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <sys/resource.h>
#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <vector>

#include "proto/base/version.hpp"

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

prometheus::ClientMetric histogram(const TimeHistogram& times) {
  prometheus::ClientMetric metric;
  metric.histogram.sample_count = times.count();
  metric.histogram.sample_sum = times.sum_s();
  const std::vector<std::uint64_t> counts = times.cumulative();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    metric.histogram.bucket.push_back({.cumulative_count = counts[i],
                                       .upper_bound = i < TimeHistogram::kBoundsS.size()
                                                          ? TimeHistogram::kBoundsS[i]
                                                          : std::numeric_limits<double>::infinity()});
  }
  return metric;
}

void add_times(const PictureTimes& times, std::vector<prometheus::MetricFamily>& families) {
  prometheus::MetricFamily stages{.name = "fanlight_stage_seconds",
                                  .help = "How long a stage of a picture of the main view took, where it ran",
                                  .type = prometheus::MetricType::Histogram};
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    prometheus::ClientMetric metric = histogram(times.stages()[stage]);
    metric.label.push_back({.name = "stage", .value = std::string(kStageNames[stage])});
    stages.metric.push_back(metric);
  }
  families.push_back(stages);
  families.push_back({.name = "fanlight_picture_age_at_finish_seconds",
                      .help = "From the capture of a volume's last frame to its first finished picture",
                      .type = prometheus::MetricType::Histogram,
                      .metric = {histogram(times.ages())}});
}

std::string label_of(PictureLiveness::State state) {
  return PictureLiveness::name(state);
}
std::string label_of(PictureLiveness::Cause cause) {
  return PictureLiveness::name(cause);
}
std::string label_of(FrameOrigin origin) {
  return std::string(name_of(origin));
}

/// One value for each that Enum may be, under the label `label`: 1 for what holds, 0 for the others.
template <typename Enum>
prometheus::MetricFamily one_of(const std::string& name, const char* help, const char* label,
                                std::size_t values, Enum holds) {
  prometheus::MetricFamily all{.name = name, .help = help, .type = prometheus::MetricType::Gauge};
  for (std::size_t i = 0; i < values; ++i) {
    prometheus::ClientMetric metric;
    metric.label.push_back({.name = label, .value = label_of(static_cast<Enum>(i))});
    metric.gauge.value = static_cast<Enum>(i) == holds ? 1 : 0;
    all.metric.push_back(metric);
  }
  return all;
}

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) / 1e9;
}

/// Of the process, under the names that all exporters use. Linux only: proc(5).
void add_process(std::vector<prometheus::MetricFamily>& families) {
  std::ifstream file("/proc/self/stat");
  std::string line;
  std::getline(file, line);
  // The name of the program, in brackets, may have spaces in it.
  std::istringstream fields(line.substr(std::min(line.size(), line.rfind(')') + 1)));
  std::vector<double> values;
  for (std::string field; fields >> field;) values.push_back(std::strtod(field.c_str(), nullptr));
  constexpr std::size_t kUser = 11;
  constexpr std::size_t kSystem = 12;
  constexpr std::size_t kStart = 19;
  constexpr std::size_t kResident = 21;
  if (values.size() <= kResident) return;
  const auto ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  // Once: a clock that is set must not look like a new start.
  static const double started_s =
      seconds_of(CLOCK_REALTIME) - seconds_of(CLOCK_BOOTTIME) + values[kStart] / ticks;
  const auto gauge = prometheus::MetricType::Gauge;
  families.push_back(family("process_cpu_seconds_total", "Processor time of the process",
                            prometheus::MetricType::Counter, (values[kUser] + values[kSystem]) / ticks));
  families.push_back(family("process_resident_memory_bytes", "Memory of the process", gauge,
                            values[kResident] * static_cast<double>(sysconf(_SC_PAGESIZE))));
  families.push_back(
      family("process_start_time_seconds", "When the process started, since 1970", gauge, started_s));
  std::error_code failure;
  const std::filesystem::directory_iterator open("/proc/self/fd", failure);
  if (!failure)
    families.push_back(family("process_open_fds", "Open file descriptors of the process", gauge,
                              static_cast<double>(std::distance(begin(open), end(open)))));
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) == 0)
    families.push_back(family("process_max_fds", "As many as the process may have open", gauge,
                              static_cast<double>(limit.rlim_cur)));
}

}  // namespace

std::string metrics_text(const ServerState& state, const PictureHub& hub) {
  std::vector<prometheus::MetricFamily> families;
  for (const NamedCount& count : named_counts(state.pipeline, state.counters)) {
    const bool total = count.kind == CountKind::kTotal;
    families.push_back(family(fmt::format("fanlight_{}{}", count.name, total ? "_total" : ""), count.help,
                              total ? prometheus::MetricType::Counter : prometheus::MetricType::Gauge,
                              static_cast<double>(count.value)));
  }
  for (const NamedValue& value : named_values(state.pipeline)) {
    families.push_back(family(fmt::format("fanlight_{}", value.name), value.help,
                              prometheus::MetricType::Gauge, value.value));
  }
  families.push_back(family(
      "fanlight_probe_streaming", "1 while a probe streams, 0 while it is lost or there is none",
      prometheus::MetricType::Gauge, state.probe.status().state == ProbeStatus::State::kStreaming ? 1 : 0));
  const PictureLiveness::Report& liveness = state.liveness.report();
  families.push_back(family("fanlight_picture_live",
                            "1 while the main view shows what the probe sees now, 0 while its picture is old",
                            prometheus::MetricType::Gauge, liveness.live() ? 1 : 0));
  families.push_back(one_of("fanlight_picture_state", "1 for the state of the picture, 0 for the others",
                            "state", PictureLiveness::kStates, liveness.state));
  families.push_back(one_of("fanlight_picture_cause", "1 for what keeps new pictures away, 0 for all else",
                            "cause", PictureLiveness::kCauses, liveness.cause));
  families.push_back(
      one_of("fanlight_frame_origin",
             "1 for where the frames come from, at the first of several senders; 0 for all else", "origin",
             kFrameOriginNames.size(), liveness.origin));
  families.push_back(
      family("fanlight_picture_age_seconds",
             "From the capture of the newest picture's volume to now; -1 before the first picture",
             prometheus::MetricType::Gauge, liveness.age_s));
  families.push_back(
      family("fanlight_picture_resting",
             "1 while nothing is rendered because there are no viewers: the picture is then not live",
             prometheus::MetricType::Gauge, liveness.state == PictureLiveness::State::kResting ? 1 : 0));
  families.push_back(family("fanlight_picture_frozen",
                            "1 while displays look at one of the last volumes: the picture is then not live",
                            prometheus::MetricType::Gauge,
                            liveness.state == PictureLiveness::State::kFrozen ? 1 : 0));
  families.push_back(family("fanlight_ready",
                            "1 while a display that comes sees pictures of the source, as /readyz says",
                            prometheus::MetricType::Gauge, liveness.ready() ? 1 : 0));
  families.push_back(family("fanlight_replay", "1 while the source is a recording, 0 while it is live",
                            prometheus::MetricType::Gauge, state.replay.is_replay() ? 1 : 0));
  const RecordingStatus& recording = state.recording.status();
  families.push_back(
      family("fanlight_recording", "1 while frames are recorded, also to keep the last minutes; else 0",
             prometheus::MetricType::Gauge, recording.state == RecordingStatus::State::kRecording ? 1 : 0));
  families.push_back(
      family("fanlight_recording_halted", "1 while a recording waits for free space on its disk",
             prometheus::MetricType::Gauge, recording.state == RecordingStatus::State::kNoRoom ? 1 : 0));
  families.push_back(
      family("fanlight_recording_frames_missed",
             "Frames that the disk did not take in time or had no room for, of the present recording",
             prometheus::MetricType::Gauge, static_cast<double>(recording.frames_missed)));
  families.push_back(family("fanlight_recordings_ended_total", "Recordings that have ended",
                            prometheus::MetricType::Counter, static_cast<double>(recording.finished)));
  families.push_back(family("fanlight_sessions", "Displays connected", prometheus::MetricType::Gauge,
                            static_cast<double>(hub.subscriber_count())));
  families.push_back(family("fanlight_scene_revision", "Number of the scene in force",
                            prometheus::MetricType::Gauge,
                            static_cast<double>(state.scene_store.in_force().revision)));
  add_times(state.times, families);
  add_process(families);
  prometheus::MetricFamily build =
      family("fanlight_build_info", "1; the version is its label", prometheus::MetricType::Gauge, 1);
  build.metric.front().label.push_back({.name = "version", .value = version()});
  families.push_back(build);
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace fanlight
