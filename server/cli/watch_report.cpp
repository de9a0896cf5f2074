// SPDX-License-Identifier: Apache-2.0
#include "server/cli/watch_report.hpp"
#include "server/cli/json_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
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

/// The median age of a second's pictures; none where no age is known. Sorts the ages.
std::optional<double> median_age_ms(WatchedSecond& second) {
  if (second.ages_ms.empty()) return std::nullopt;
  std::ranges::sort(second.ages_ms);
  return second.ages_ms[second.ages_ms.size() / 2];
}

}  // namespace

void print_json(WatchedSecond& second, const v1::Liveness& liveness, const v1::Statistics* statistics) {
  using Json = nlohmann::ordered_json;
  const v1::Statistics counts = statistics == nullptr ? v1::Statistics() : *statistics;
  const auto known = [&](const Json& value) { return statistics == nullptr ? Json() : value; };
  const std::optional<double> age_ms = median_age_ms(second);
  const Json report = {{"pictures", second.pictures},
                       {"bytes", second.bytes},
                       {"age_ms", age_ms ? Json(*age_ms) : Json()},
                       {"offered", known(counts.pictures_offered())},
                       {"sent", known(counts.pictures_sent())},
                       {"skipped", known(counts.pictures_skipped())},
                       {"volumes_assembled", known(counts.volumes_assembled())},
                       {"volumes_dropped", known(counts.volumes_dropped())},
                       {"frames_lost", known(counts.frames_lost())},
                       {"sessions", known(counts.sessions())},
                       {"source", known(printable(counts.source_state()))},
                       {"picture", state_name(liveness)},
                       {"picture_age_s", liveness.age_s()},
                       {"reason", printable(liveness.sentence())}};
  fmt::print("{}\n", json_text(report));
}

void print_text(WatchedSecond& second, const v1::Liveness& liveness, const v1::Statistics* statistics) {
  const std::optional<double> age_ms = median_age_ms(second);
  fmt::print("{}; {:4} pictures, {:7.1f} kB", state_text(liveness), second.pictures,
             static_cast<double>(second.bytes) / 1e3);
  if (age_ms) fmt::print(", last frame {:6.1f} ms ago (median)", *age_ms);
  if (statistics != nullptr) {
    fmt::print("; sent {}, skipped {} of {}; {} volumes, {} dropped; {} displays; source {}",
               statistics->pictures_sent(), statistics->pictures_skipped(), statistics->pictures_offered(),
               statistics->volumes_assembled(), statistics->volumes_dropped(), statistics->sessions(),
               printable(statistics->source_state()));
  }
  fmt::print("\n");
}

}  // namespace fanlight
