// SPDX-License-Identifier: Apache-2.0
#include "server/cli/watch_report.hpp"
#include "server/cli/json_text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "proto/base/printable.hpp"
#include "server/state/picture_liveness.hpp"

namespace fanlight {

namespace {

/// "live", "delayed", "not live" or "waiting", as `fanlight watch` and /healthz say it.
const char* state_name(const v1::Liveness& liveness) {
  return PictureLiveness::name(static_cast<PictureLiveness::State>(liveness.state()));
}

/// "not live, 34.2 s old: The probe is lost."
std::string state_text(const v1::Liveness& liveness) {
  const std::string age = liveness.age_s() < 0 ? "" : fmt::format(", {:.1f} s old", liveness.age_s());
  const bool explains = liveness.state() != v1::Liveness::LIVE || liveness.cause() != v1::Liveness::NONE ||
                        liveness.origin() != v1::Liveness::PROBE;
  return fmt::format("{}{}{}{}", state_name(liveness), age, explains ? ": " : "",
                     explains ? printable(liveness.sentence()) : "");
}

}  // namespace

void print_json(const WatchedSecond& second, double age_ms, const v1::Liveness& liveness,
                const v1::Statistics& statistics) {
  const nlohmann::ordered_json report = {{"pictures", second.pictures},
                                         {"bytes", second.bytes},
                                         {"age_ms", age_ms},
                                         {"offered", statistics.pictures_offered()},
                                         {"sent", statistics.pictures_sent()},
                                         {"skipped", statistics.pictures_skipped()},
                                         {"volumes_assembled", statistics.volumes_assembled()},
                                         {"volumes_dropped", statistics.volumes_dropped()},
                                         {"frames_lost", statistics.frames_lost()},
                                         {"sessions", statistics.sessions()},
                                         {"source", printable(statistics.source_state())},
                                         {"picture", state_name(liveness)},
                                         {"picture_age_s", liveness.age_s()},
                                         {"reason", printable(liveness.sentence())}};
  fmt::print("{}\n", json_text(report));
}

void print_text(const WatchedSecond& second, double age_ms, const v1::Liveness& liveness,
                const v1::Statistics& statistics) {
  fmt::print(
      "{}; {:4} pictures, {:7.1f} kB, last frame {:6.1f} ms ago (median); sent {}, skipped {} of {}; {} "
      "volumes, {} "
      "dropped; {} displays; source {}\n",
      state_text(liveness), second.pictures, static_cast<double>(second.bytes) / 1e3, age_ms,
      statistics.pictures_sent(), statistics.pictures_skipped(), statistics.pictures_offered(),
      statistics.volumes_assembled(), statistics.volumes_dropped(), statistics.sessions(),
      printable(statistics.source_state()));
}

}  // namespace fanlight
