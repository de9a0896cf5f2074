// SPDX-License-Identifier: Apache-2.0
#include "server/cli/measurement_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <span>
#include <utility>
#include <vector>

#include "proto/base/printable.hpp"
#include "proto/model/measurement_file.hpp"
#include "server/state/measurement_file.hpp"
#include "server/state/measurement_store.hpp"

namespace fanlight {

namespace {

struct Kept {
  std::vector<v1::Measurement> measurements;
  std::vector<std::string> troubles;  // what could not be read, a sentence each
};

Kept kept_with(const std::filesystem::path& recording) {
  const auto text = read_measurement_file(measurements_path_of(recording));
  if (!text) return {.measurements = {}, .troubles = {text.error().message}};
  if (!*text) return {};
  ReadMeasurements read = parse_measurements(**text);
  MeasurementStore store;
  Kept kept{.measurements = {}, .troubles = std::move(read.troubles)};
  for (const std::string& trouble : store.load(std::move(read.file))) kept.troubles.push_back(trouble);
  for (const MeasurementStore::Kept& each : store.all()) kept.measurements.push_back(each.measurement);
  return kept;
}

std::string kind_of(const v1::Measurement& measurement) {
  std::string kind = v1::Measurement::Kind_Name(measurement.kind());
  std::ranges::transform(kind, kind.begin(), [](unsigned char letter) { return std::tolower(letter); });
  return kind;
}

std::string line_of(const v1::Measurement& measurement) {
  const std::string place = measurement.place().empty() ? "" : " " + measurement.place();
  std::string line = fmt::format("  {}, {}{}, frames {} to {}:", measurement.name(), kind_of(measurement),
                                 place, measurement.first_frame_number(), measurement.last_frame_number());
  for (const v1::Measurement::Figure& figure : measurement.figures())
    line += fmt::format(" {} {:.2f} ± {:.2f} {};", figure.name(), figure.value(), figure.deviation(),
                        figure.unit());
  line.back() = '\n';
  return line;
}

}  // namespace

std::string measurement_lines(const std::filesystem::path& recording) {
  const Kept kept = kept_with(recording);
  if (kept.measurements.empty() && kept.troubles.empty()) return "";
  std::string text = fmt::format("measurements: {} in {}; not for diagnosis\n", kept.measurements.size(),
                                 printable(measurements_path_of(recording).filename().string()));
  for (const v1::Measurement& each : kept.measurements) text += line_of(each);
  constexpr std::size_t kMostLines = 5;
  for (const std::string& trouble :
       std::span(kept.troubles).first(std::min(kept.troubles.size(), kMostLines)))
    text += fmt::format("  not read: {}\n", trouble);
  if (kept.troubles.size() > kMostLines)
    text += fmt::format("  not read: {} more\n", kept.troubles.size() - kMostLines);
  return text;
}

void add_measurements(nlohmann::ordered_json& report, const std::filesystem::path& recording) {
  const Kept kept = kept_with(recording);
  if (!kept.troubles.empty()) report["measurements_not_read"] = kept.troubles;
  if (kept.measurements.empty()) return;
  auto list = nlohmann::ordered_json::array();
  for (const v1::Measurement& each : kept.measurements) {
    auto figures = nlohmann::ordered_json::array();
    for (const v1::Measurement::Figure& figure : each.figures()) {
      figures.push_back({{"name", figure.name()},
                         {"value", figure.value()},
                         {"unit", figure.unit()},
                         {"deviation", figure.deviation()}});
    }
    list.push_back({{"name", each.name()},
                    {"kind", kind_of(each)},
                    {"place", each.place()},
                    {"first_frame", each.first_frame_number()},
                    {"last_frame", each.last_frame_number()},
                    {"figures", figures}});
  }
  report["measurements"] = list;
}

}  // namespace fanlight
