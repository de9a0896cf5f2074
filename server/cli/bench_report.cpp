// SPDX-License-Identifier: Apache-2.0
#include "server/cli/bench_report.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <string_view>

#include "server/bench/run.hpp"

namespace fanlight {

namespace {

double ratio(const PipelineTimes& times) {
  return quantile(times.pipelined.volumes_a_second, 0.5) / quantile(times.serial.volumes_a_second, 0.5);
}

nlohmann::ordered_json as_json(const BlockFigures& figures) {
  return {{"volumes", figures.volumes},
          {"pictures", figures.pictures},
          {"encoded", figures.encoded},
          {"volumes_a_second", figures.volumes_a_second},
          {"volumes_a_second_p50", quantile(figures.volumes_a_second, 0.5)},
          {"light_ms", {{"p50", quantile(figures.light_ms, 0.5)}, {"p99", quantile(figures.light_ms, 0.99)}}},
          {"busy_cores", figures.busy_cores}};
}

nlohmann::ordered_json as_json(const StageOverlap& overlap) {
  return {{"light_in_cast", overlap.light_in_cast.value()},
          {"light_in_work", overlap.light_in_work.value()},
          {"upload_in_work", overlap.upload_in_work.value()},
          {"read_back_in_work", overlap.read_back_in_work.value()},
          {"encoding_in_work", overlap.encoding_in_work.value()}};
}

void print_figures(std::string_view name, const BlockFigures& figures) {
  fmt::print(
      "  {:<10} {:7.3f} volumes a second, passes 2 and 3 done {:.1f} ms after pass 1, {:.2f} cores busy\n",
      name, quantile(figures.volumes_a_second, 0.5), quantile(figures.light_ms, 0.5), figures.busy_cores);
}

void print_overlap(std::string_view name, const StageOverlap& overlap) {
  fmt::print(
      "  {:<10} {:.1f} % of passes 2 and 3 lay in another volume's pass 1, {:.1f} % in its passes 0 and 1\n",
      name, 100 * overlap.light_in_cast.value(), 100 * overlap.light_in_work.value());
  fmt::print(
      "  {:<10} {:.1f} % of upload, {:.1f} % of read-back, {:.1f} % of encoding lay in GPU work for others\n",
      "", 100 * overlap.upload_in_work.value(), 100 * overlap.read_back_in_work.value(),
      100 * overlap.encoding_in_work.value());
}

std::string_view name_of(Arrival arrival) {
  return arrival == Arrival::kAtOnce ? "at once" : "frame by frame";
}

double dropped_share(const BlockFigures& figures) {
  return static_cast<double>(figures.dropped) / static_cast<double>(figures.volumes + figures.dropped);
}

}  // namespace

nlohmann::ordered_json as_json(const BenchRow& row, const PipelineTimes& times) {
  return {{"name", row.name},
          {"input", row.input},
          {"picture", row.picture},
          {"settings", fmt::format("{} {} {}", row.method, row.settings, row.changes)},
          {"serial", as_json(times.serial)},
          {"pipelined", as_json(times.pipelined)},
          {"live", as_json(times.live)},
          {"pipelined_over_serial", ratio(times)},
          {"shares", as_json(times.overlap)},
          {"sweep_ms", times.sweep_ms},
          {"live_dropped", times.live.dropped},
          {"live_latency_ms",
           {{"p50", quantile(times.live.latency_ms, 0.5)}, {"p99", quantile(times.live.latency_ms, 0.99)}}},
          {"live_shares", as_json(times.live_overlap)}};
}

void print_pipeline(const BenchRow& row, const PipelineTimes& times) {
  fmt::print("{}: {} volumes, {} pictures, {} encoded\n", row.name, times.pipelined.volumes,
             times.pipelined.pictures, times.pipelined.encoded);
  print_figures("serial", times.serial);
  print_figures("pipelined", times.pipelined);
  print_figures("live", times.live);
  fmt::print(
      "  live: a sweep every {:.1f} ms, {} volumes dropped, a picture {:.1f} ms after its last frame\n",
      times.sweep_ms, times.live.dropped, quantile(times.live.latency_ms, 0.5));
  fmt::print("  pipelined over serial {:.3f}\n", ratio(times));
  print_overlap("pipelined", times.overlap);
  print_overlap("live", times.live_overlap);
  std::fflush(stdout);
}

nlohmann::ordered_json as_json(const BenchRow& row, const RowRates& rates) {
  nlohmann::ordered_json ways = nlohmann::ordered_json::array();
  for (const RateFigures& rate : rates) {
    const BlockFigures& figures = rate.figures;
    ways.push_back(
        {{"frames_come", name_of(rate.arrival)},
         {"volumes", figures.volumes},
         {"dropped", figures.dropped},
         {"encoded", figures.encoded},
         {"volumes_a_second", figures.volumes_a_second},
         {"volumes_a_second_p50", quantile(figures.volumes_a_second, 0.5)},
         {"latency_ms",
          {{"p50", quantile(figures.latency_ms, 0.5)}, {"p95", quantile(figures.latency_ms, 0.95)}}},
         {"busy_cores", figures.busy_cores}});
  }
  return {{"name", row.name},
          {"input", row.input},
          {"picture", row.picture},
          {"settings", fmt::format("{} {} {}", row.method, row.settings, row.changes)},
          {"ways", ways}};
}

namespace {

constexpr std::string_view kRateRow = "{:<16} {:<15} {:>10} {:>9} {:>10} {:>10} {:>7}\n";

}  // namespace

void print_rates_head() {
  fmt::print(kRateRow, "", "", "volumes", "", "latency", "latency", "busy");
  fmt::print(kRateRow, "row", "frames come", "a second", "dropped", "p50 ms", "p95 ms", "cores");
}

void print_rates(const BenchRow& row, const RowRates& rates) {
  for (const RateFigures& rate : rates) {
    const BlockFigures& figures = rate.figures;
    fmt::print(kRateRow, row.name, name_of(rate.arrival),
               fmt::format("{:.1f}", quantile(figures.volumes_a_second, 0.5)),
               fmt::format("{:.0f} %", 100 * dropped_share(figures)),
               fmt::format("{:.1f}", quantile(figures.latency_ms, 0.5)),
               fmt::format("{:.1f}", quantile(figures.latency_ms, 0.95)),
               fmt::format("{:.2f}", figures.busy_cores));
  }
  std::fflush(stdout);
}

nlohmann::ordered_json as_json(const HeldMemory& held) {
  return {{"volumes", held.volumes},
          {"resident_mb", held.resident_mb},
          {"own_mb", held.own_mb},
          {"ring_mb", held.ring_mb}};
}

void print_held(const HeldMemory& held) {
  fmt::print("{:10} {:10.1f} {:10.1f} {:10.1f}\n", held.volumes, held.resident_mb, held.own_mb, held.ring_mb);
  std::fflush(stdout);
}

nlohmann::ordered_json as_json(std::span<const MemoryPart> parts) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const MemoryPart& part : parts) list.push_back({{"name", part.name}, {"mb", part.mb}});
  return list;
}

void print_parts(std::span<const MemoryPart> parts) {
  fmt::print("\nMemory added by each step, and resident pages of files, MB\n");
  double sum_mb = 0;
  for (const MemoryPart& part : parts) {
    fmt::print("{:<38} {:8.1f}\n", part.name, part.mb);
    sum_mb += part.mb;
  }
  fmt::print("{:<38} {:8.1f}\n", "all", sum_mb);
}

nlohmann::ordered_json report_of(const RenderDevice& device) {
  const GpuCandidate& candidate = device.gpu->candidate();
  return {{"device", candidate.name}, {"kind", candidate.kind}, {"driver", candidate.driver}};
}

}  // namespace fanlight
