// SPDX-License-Identifier: Apache-2.0
#include "server/bench/trace_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace fanlight {

namespace {

// Lengths in units of the picture, which are pixels at its natural size.
constexpr double kLeft = 130;
constexpr double kRight = 20;
constexpr double kTop = 14;
constexpr double kWidth = 1200;
constexpr double kLaneHeight = 34;
constexpr double kLaneGap = 12;
constexpr double kAxisHeight = 40;

constexpr std::array<std::string_view, 3> kLanes = {"passes 0 and 1", "passes 2 and 3", "encoding"};
// A volume, the next one and the one after it.
constexpr std::array<std::string_view, 3> kColours = {"#0072b2", "#e69f00", "#009e73"};

struct Bar {
  std::size_t lane = 0;
  StageSpan span;
  std::uint64_t volume_id = 0;
  std::string_view label;
};

std::vector<Bar> bars_of(const BlockTrace& block) {
  std::vector<Bar> bars;
  const std::int64_t ahead_ns = gpu_clock_ahead_ns(block);
  for (const VolumeTrace& volume : block.volumes) {
    for (std::size_t stage = 0; stage < kStages; ++stage) {
      const StageSpan& span = volume.stages[stage];
      if (span.end_ns == 0) continue;
      const bool light = stage >= static_cast<std::size_t>(Stage::kFilter);
      bars.push_back({.lane = light ? 1U : 0U,
                      .span = {.begin_ns = span.begin_ns - ahead_ns, .end_ns = span.end_ns - ahead_ns},
                      .volume_id = volume.volume_id,
                      .label = kStageNames[stage]});
    }
  }
  for (const EncodingTrace& encoding : block.encodings)
    bars.push_back({.lane = 2, .span = encoding.span, .volume_id = encoding.volume_id, .label = ""});
  return bars;
}

/// 1, 2 or 5 times a power of ten: some ten of them in `all`.
double tick_ms(double all_ms) {
  const double power = std::pow(10, std::floor(std::log10(std::max(all_ms, 1e-3) / 10)));
  for (const double times : {1.0, 2.0, 5.0}) {
    if (all_ms / (times * power) <= 14) return times * power;
  }
  return 10 * power;
}

double lane_top(std::size_t lane) {
  return kTop + static_cast<double>(lane) * (kLaneHeight + kLaneGap);
}

}  // namespace

std::string trace_picture(const BlockTrace& block) {
  const std::vector<Bar> bars = bars_of(block);
  if (bars.empty()) return {};
  const std::int64_t begin_ns =
      std::ranges::min(bars, {}, [](const Bar& bar) { return bar.span.begin_ns; }).span.begin_ns;
  const std::int64_t end_ns =
      std::ranges::max(bars, {}, [](const Bar& bar) { return bar.span.end_ns; }).span.end_ns;
  const double all_ms = static_cast<double>(end_ns - begin_ns) / 1e6;
  const double scale = (kWidth - kLeft - kRight) / all_ms;
  const auto x_of = [&](std::int64_t ns) { return kLeft + scale * static_cast<double>(ns - begin_ns) / 1e6; };
  const double bottom = lane_top(kLanes.size()) - kLaneGap;

  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      kWidth, bottom + kAxisHeight);
  const double tick = tick_ms(all_ms);
  for (double ms = 0; ms <= all_ms; ms += tick) {
    const double x = kLeft + scale * ms;
    svg += fmt::format(
        "<path d=\"M{0:.1f} {1}V{2}\" stroke=\"#ddd\"/><text x=\"{0:.1f}\" y=\"{3}\" "
        "text-anchor=\"middle\">{4:g}</text>\n",
        x, kTop, bottom, bottom + 18, ms);
  }
  svg += fmt::format("<text x=\"{}\" y=\"{}\">ms</text>\n", kLeft - 40, bottom + 18);
  for (std::size_t lane = 0; lane < kLanes.size(); ++lane) {
    svg += fmt::format("<text x=\"8\" y=\"{:.1f}\">{}</text>\n", lane_top(lane) + 0.62 * kLaneHeight,
                       kLanes[lane]);
  }
  for (const Bar& bar : bars) {
    const double x = x_of(bar.span.begin_ns);
    const double width = std::max(x_of(bar.span.end_ns) - x, 0.5);
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{}\" fill=\"{}\" stroke=\"white\" "
        "stroke-width=\"0.5\"><title>volume {}{}{}, {:.2f} ms</title></rect>\n",
        x, lane_top(bar.lane), width, kLaneHeight, kColours[bar.volume_id % kColours.size()], bar.volume_id,
        bar.label.empty() ? "" : ", ", bar.label, bar.span.ms());
    if (bar.label == "cast") {
      svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\" fill=\"white\">{}</text>\n",
                         x + width / 2, lane_top(bar.lane) + 0.62 * kLaneHeight, bar.volume_id);
    }
  }
  return svg + "</svg>\n";
}

}  // namespace fanlight
