#include "server/metrics_text.hpp"

#include <prometheus/metric_family.h>
#include <prometheus/text_serializer.h>

#include <vector>

namespace fanlight {

namespace {

struct CounterRow {
  const char* name;
  const char* help;
  const Counter& counter;
};

prometheus::MetricFamily family(const char* name, const char* help, prometheus::MetricType type,
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

std::string metrics_text(const StreamContext& context) {
  const AcquisitionCounters& acquisition = context.house.acquisition;
  const RingCounters& ring = context.house.ring;
  const RenderCounters& render = context.house.render;
  const ServerCounters& server = context.counters;
  const CounterRow rows[] = {
      {"fanlight_frames_received_total", "Frames that came from the source", acquisition.frames_received},
      {"fanlight_frames_missing_total", "Gaps in the frames' sequence", acquisition.frames_missing},
      {"fanlight_frames_assembled_total", "Frames in published volumes", acquisition.frames_assembled},
      {"fanlight_frames_invalid_total", "Frames marked invalid or with an unusable angle",
       acquisition.frames_invalid},
      {"fanlight_frames_over_capacity_total", "Frames of sweeps longer than a volume can hold",
       acquisition.frames_over_capacity},
      {"fanlight_frames_in_short_volumes_total", "Frames of sweeps whose angle did not move",
       acquisition.frames_in_short_volumes},
      {"fanlight_frames_abandoned_total", "Frames of the sweep under way when the source was stopped",
       acquisition.frames_abandoned},
      {"fanlight_volumes_short_total", "Sweeps dropped because their angle did not move",
       acquisition.volumes_short},
      {"fanlight_volumes_published_total", "Volumes put into the ring", ring.volumes_published},
      {"fanlight_volumes_taken_total", "Volumes that the renderer took", ring.volumes_taken},
      {"fanlight_volumes_dropped_total", "Volumes replaced unread by a newer one", ring.volumes_dropped},
      {"fanlight_pass1_runs_total", "Ray casts", render.pass1_runs},
      {"fanlight_pass2_runs_total", "Runs of filter, light and finish", render.pass2_runs},
      {"fanlight_pictures_finished_total", "Pictures rendered", render.pictures_finished},
      {"fanlight_pictures_outdated_total", "Pictures done after one of a newer volume",
       render.pictures_outdated},
      {"fanlight_pictures_replaced_total", "Pictures replaced before the server read them",
       render.pictures_replaced},
      {"fanlight_pictures_encoded_total", "Pictures encoded", server.pictures_encoded},
      {"fanlight_pictures_offered_total", "Pictures offered to sessions", server.pictures_offered},
      {"fanlight_pictures_sent_total", "Pictures sent to sessions", server.pictures_sent},
      {"fanlight_pictures_skipped_total", "Pictures that a session was too slow for",
       server.pictures_skipped},
      {"fanlight_sessions_opened_total", "Displays that connected", server.sessions_opened},
      {"fanlight_sessions_closed_total", "Displays that left", server.sessions_closed},
      {"fanlight_connections_refused_total", "Connections beyond the limit", server.connections_refused},
      {"fanlight_requests_refused_total", "HTTP requests that were refused", server.requests_refused},
      {"fanlight_messages_refused_total", "WebSocket messages that were refused", server.messages_refused},
      {"fanlight_scene_changes_total", "Scene changes taken", server.scene_changes},
      {"fanlight_scene_refusals_total", "Scene changes refused", server.scene_refusals},
  };
  std::vector<prometheus::MetricFamily> families;
  for (const CounterRow& row : rows) {
    families.push_back(family(row.name, row.help, prometheus::MetricType::Counter,
                              static_cast<double>(row.counter.value())));
  }
  families.push_back(family("fanlight_sessions", "Displays connected", prometheus::MetricType::Gauge,
                            static_cast<double>(context.hub.sessions().size())));
  families.push_back(family("fanlight_scene_revision", "Number of the scene in force",
                            prometheus::MetricType::Gauge,
                            static_cast<double>(context.desk.in_force().revision)));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace fanlight
