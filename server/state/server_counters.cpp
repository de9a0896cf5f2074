// SPDX-License-Identifier: Apache-2.0
#include "server/state/server_counters.hpp"

namespace fanlight {

namespace {

template <typename Table, typename Counters>
void append(std::vector<NamedCount>& counts, const Table& table, const Counters& counters) {
  for (const auto& row : table) {
    counts.push_back({.name = row.name, .help = row.help, .value = row.value(counters), .kind = row.kind});
  }
}

}  // namespace

std::vector<NamedCount> named_counts(const PipelineCounters& pipeline, const ServerCounters& server) {
  std::vector<NamedCount> counts;
  pipeline.acquisition.seq_lock.read([&] {
    counts.clear();
    append(counts, kAcquisitionTable, pipeline.acquisition);
  });
  append(counts, kProbeTable, pipeline.probe);
  append(counts, kIgtlTable, pipeline.igtl);
  append(counts, kQueueTable, pipeline.queue);
  append(counts, kRingTable, pipeline.ring);
  append(counts, kRenderTable, pipeline.render);
  append(counts, kServerTable, server);
  return counts;
}

std::vector<NamedValue> named_values(const PipelineCounters& pipeline) {
  std::vector<NamedValue> values;
  values.reserve(kAcquisitionValueTable.size());
  for (const auto& row : kAcquisitionValueTable) {
    values.push_back({.name = row.name, .help = row.help, .value = row.value(pipeline.acquisition)});
  }
  return values;
}

}  // namespace fanlight
