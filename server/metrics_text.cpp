#include "server/metrics_text.hpp"

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

std::string metrics_text(const StreamContext& context) {
  std::vector<prometheus::MetricFamily> families;
  for (const NamedCount& count : named_counts(context.house, context.counters)) {
    families.push_back(family(fmt::format("fanlight_{}_total", count.name), count.help,
                              prometheus::MetricType::Counter, static_cast<double>(count.value)));
  }
  families.push_back(family("fanlight_sessions", "Displays connected", prometheus::MetricType::Gauge,
                            static_cast<double>(context.hub.sessions().size())));
  families.push_back(family("fanlight_scene_revision", "Number of the scene in force",
                            prometheus::MetricType::Gauge,
                            static_cast<double>(context.desk.in_force().revision)));
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace fanlight
