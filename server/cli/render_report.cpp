// SPDX-License-Identifier: Apache-2.0
#include "server/cli/render_report.hpp"
#include "server/cli/json_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <string_view>

#include "proto/model/echo_levels.hpp"

namespace fanlight {

namespace {

/// Quantiles of the depths of the surface in mm, for shares from 0 to 1. Empty without a surface.
std::vector<float> depth_quantiles_mm(const std::vector<float>& smooth_mm, std::span<const double> shares) {
  std::vector<float> depths_mm;
  std::ranges::copy_if(smooth_mm, std::back_inserter(depths_mm), [](float depth) { return depth >= 0; });
  if (depths_mm.empty()) return {};
  std::ranges::sort(depths_mm);
  std::vector<float> quantiles_mm;
  for (const double share : shares) {
    quantiles_mm.push_back(
        depths_mm[static_cast<std::size_t>(share * static_cast<double>(depths_mm.size() - 1))]);
  }
  return quantiles_mm;
}

nlohmann::ordered_json levels_json(const EchoLevels& levels) {
  if (levels.flat) return {{"flat", true}};
  if (!levels.known) return nullptr;
  return {{"fluid", levels.fluid},
          {"tissue", levels.tissue},
          {"noise", levels.noise},
          {"threshold", levels.threshold()},
          {"least_tissue", levels.least_tissue()}};
}

std::string_view near_tissue_name(NearTissueState state) {
  constexpr std::array<std::string_view, 5> kNames = {"shown", "removed", "not found", "removed to bone",
                                                      "no bone"};
  return kNames[static_cast<std::size_t>(state)];
}

nlohmann::ordered_json warnings_json(const SweepWarnings& warnings) {
  auto list = nlohmann::ordered_json::array();
  warnings.for_each([&list](const SweepWarningText& text) {
    list.push_back({{"name", text.name}, {"sentence", text.sentence}});
  });
  return list;
}

}  // namespace

RenderReport report_of(const std::string& input, const Picture& picture,
                       const std::vector<float>& smooth_mm) {
  constexpr double kShares[] = {0.05, 0.5, 0.95};
  RenderReport report{.input = input,
                      .picture = picture,
                      .dropped = {},
                      .notes = {},
                      .device = {},
                      .depth_5_50_95_mm = depth_quantiles_mm(smooth_mm, kShares)};
  for (const double stage_ms : picture.stamp.stage_ms) report.total_ms += stage_ms;
  return report;
}

nlohmann::ordered_json dropped_json(const std::vector<DroppedSweep>& dropped) {
  auto list = nlohmann::ordered_json::array();
  for (const DroppedSweep& sweep : dropped)
    list.push_back({{"volume", sweep.volume_index}, {"because", reason_of(sweep)}});
  return list;
}

void print_dropped(std::FILE* out, const std::vector<DroppedSweep>& dropped) {
  for (const DroppedSweep& sweep : dropped)
    fmt::print(out, "volume {} was dropped: {}\n", sweep.volume_index, reason_of(sweep));
}

FrameCounts frame_counts(const AcquisitionCounters& counters) {
  FrameCounts counts;
  counters.seq_lock.read([&] {
    counts = {.received = counters.frames_received.value(),
              .unused = counters.frames_unused(),
              .missing = counters.frames_missing.value()};
  });
  return counts;
}

/// Where the pixels lie: the formula of PictureView.
nlohmann::ordered_json view_json(const PictureView& view) {
  return {{"origin_mm", view.origin_mm},
          {"right", view.right},
          {"down", view.down},
          {"forward", view.forward},
          {"mm_per_pixel", view.mm_per_pixel},
          {"mm_per_pixel_per_mm", view.mm_per_pixel_per_mm},
          {"middle_column", view.middle_column},
          {"middle_row", view.middle_row}};
}

nlohmann::ordered_json figures_json(const RenderReport& report) {
  const Picture& picture = report.picture;
  return {{"volume", picture.stamp.volume.source_volume_index},
          {"frames", picture.stamp.volume.frames},
          {"width", picture.width},
          {"height", picture.height},
          {"surface_share", picture.stamp.surface_share},
          {"depth_5_50_95_mm", report.depth_5_50_95_mm},
          {"speckle_filter_left_out", report.speckle_filter_left_out},
          {"levels", levels_json(picture.stamp.levels)},
          {"uncertain_share", picture.stamp.uncertain_share},
          {"near_tissue", near_tissue_name(picture.stamp.near_tissue)},
          {"near_end_mm", picture.stamp.near_end_mm},  // null: not removed
          {"warnings", warnings_json(picture.stamp.volume.warnings)},
          {"view", view_json(picture.stamp.view)}};
}

void print_json(std::FILE* out, const RenderReport& report) {
  const Picture& picture = report.picture;
  nlohmann::ordered_json stages;
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    stages[std::string(kStageNames[stage])] = picture.stamp.stage_ms[stage];
  }
  nlohmann::ordered_json json = {{"input", report.input}};
  json.update(figures_json(report));
  json.update(nlohmann::ordered_json({{"device", report.device},
                                      {"dropped", dropped_json(report.dropped)},
                                      {"notes", report.notes},
                                      {"stage_ms", stages},
                                      {"total_ms", report.total_ms}}));
  fmt::print(out, "{}\n", json_text(json));
}

void print_text(std::FILE* out, const RenderReport& report) {
  const Picture& picture = report.picture;
  fmt::print(out, "volume {} of {} has {} frames; {} x {} pixels on {}, a surface in {:.1f} % of them\n",
             picture.stamp.volume.source_volume_index, report.input, picture.stamp.volume.frames,
             picture.width, picture.height, report.device, 100 * picture.stamp.surface_share);
  print_dropped(out, report.dropped);
  for (const std::string& note : report.notes) fmt::print(out, "note: {}\n", note);
  picture.stamp.volume.warnings.for_each(
      [out](const SweepWarningText& text) { fmt::print(out, "warning: {}\n", text.sentence); });
  if (picture.stamp.near_tissue == NearTissueState::kNotFound)
    fmt::print(out, "near tissue is shown: no fluid was found behind it\n");
  if (picture.stamp.near_tissue == NearTissueState::kNoBone)
    fmt::print(out, "neither a skull nor fluid was found: no near tissue is removed\n");
  if (picture.stamp.uncertain_share >= 0.005)
    fmt::print(
        out,
        "{:.0f} % of the surface is uncertain and dimmed: it barely stands out from the speckle, or no "
        "beam reached the side that is seen\n",
        100 * picture.stamp.uncertain_share);
  if (report.speckle_filter_left_out) {
    fmt::print(out, "the speckle filter was left out: the volume is too large for it on this GPU\n");
  }
  if (const auto& depths_mm = report.depth_5_50_95_mm; !depths_mm.empty()) {
    fmt::print(
        out,
        "its depth below the view plane: {:.1f} mm at the median, 5 % before {:.1f}, 5 % beyond {:.1f}\n",
        depths_mm[1], depths_mm[0], depths_mm[2]);
  }
  fmt::print(out, "{}\n", sentence(picture.stamp.levels));
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    fmt::print(out, "  {:<10} {:8.2f} ms\n", kStageNames[stage], picture.stamp.stage_ms[stage]);
  }
  fmt::print(out, "  {:<10} {:8.2f} ms\n", "together", report.total_ms);
}

}  // namespace fanlight
