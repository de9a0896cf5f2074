// SPDX-License-Identifier: Apache-2.0
#include "server/cli/sweep_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "acquisition/offline_volumes.hpp"
#include "server/cli/render_report.hpp"

namespace fanlight {

namespace {

constexpr std::uint64_t kMostBytes = 256 << 20;

}  // namespace

Result<SweepReport> examine_sweeps(const std::string& file, const SourceOptions& options) {
  Doorbell bell;
  ProbeLink probe(bell, bell);
  auto source = open_source(file, options, probe);
  if (!source) return source.error();
  const SourceDescription& description = (*source)->description();
  SweepReport report;
  report.too_large = description.frames_per_volume * description.geometry.frame_bytes() > kMostBytes;
  if (report.too_large) return report;
  OfflineVolumes volumes(**source);
  for (std::uint64_t bytes = 0; bytes < kMostBytes || report.volumes < 2;) {
    const auto volume = volumes.next();
    if (!volume) return volume.error();
    report.whole = !*volume;
    if (report.whole) break;
    const VolumeStamp& stamp = (*volume)->stamp();
    ++report.volumes;
    bytes += (*volume)->geometry().frame_bytes() * stamp.frames;
    for (std::size_t i = 0; i < kSweepWarnings; ++i)
      if (stamp.warnings.has(static_cast<SweepWarning>(i))) ++report.warned[i];
    (void)volumes.dropped();  // before its queue is full
  }
  report.dropped = volumes.dropped();
  report.whole |= description.volumes > 0 && report.volumes + report.dropped.size() >= description.volumes;
  return report;
}

std::string warnings_text(const WarnedVolumes& warned, std::uint64_t volumes, std::string_view before) {
  std::string text;
  for (std::size_t i = 0; i < kSweepWarnings; ++i) {
    if (warned[i] == 0) continue;
    text += fmt::format("{}warning: {} of {} volume{}: {}\n", before, warned[i], volumes,
                        volumes == 1 ? "" : "s", kSweepWarningTexts[i].sentence);
  }
  return text;
}

nlohmann::ordered_json warnings_json(const WarnedVolumes& warned) {
  auto list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < kSweepWarnings; ++i) {
    if (warned[i] == 0) continue;
    const SweepWarningText& text = kSweepWarningTexts[i];
    list.push_back({{"name", text.name}, {"sentence", text.sentence}, {"volumes", warned[i]}});
  }
  return list;
}

std::string sweep_text(const SweepReport& report) {
  constexpr std::size_t kMostShown = 5;
  if (report.too_large) return "  examined    none: a sweep has over 256 MB of frames\n";
  std::string text = fmt::format("  examined    {}{} volume{}\n", report.whole ? "all, " : "the first ",
                                 report.volumes, report.volumes == 1 ? "" : "s");
  if (report.volumes == 0) text += "  warning: No sweep of the recording can be rendered.\n";
  for (std::size_t i = 0; i < std::min(kMostShown, report.dropped.size()); ++i) {
    text += fmt::format("  warning: Volume {} is dropped: {}.\n", report.dropped[i].volume_index,
                        reason_of(report.dropped[i]));
  }
  if (report.dropped.size() > kMostShown)
    text += fmt::format("  warning: {} more volumes are dropped.\n", report.dropped.size() - kMostShown);
  text += warnings_text(report.warned, report.volumes, "  ");
  return text;
}

void add_sweeps(nlohmann::ordered_json& json, const SweepReport& report) {
  json["volumes_examined"] = report.volumes;
  json["all_examined"] = report.whole;
  json["dropped"] = dropped_json(report.dropped);
  json["warnings"] = warnings_json(report.warned);
}

}  // namespace fanlight
