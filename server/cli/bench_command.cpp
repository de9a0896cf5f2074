// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/base/file_replacement.hpp"
#include "renderer/cast_means.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/bench/limit.hpp"
#include "server/bench/memory.hpp"
#include "server/bench/pipeline.hpp"
#include "server/bench/run.hpp"
#include "server/bench/scale.hpp"
#include "server/bench/work.hpp"
#include "server/cli/bench_report.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/named_option.hpp"
#include "server/cli/progress_line.hpp"

namespace fanlight {

namespace {

struct BenchOptions {
  std::string only;
  std::string input;
  std::string geometry_path;
  std::string changes;
  int count = 9;
  std::string gpu;
  std::optional<BufferAccess> access;  // absent: what the device does by itself
  bool one_device = false;
  bool as_gpu = false;
  bool json = false;
  int volumes = 8;
  int rate_volumes = 40;
  double offered_hz = 30;
  std::optional<double> sweep_ms;
  std::filesystem::path trace;
  int memory_volumes = 100;
};

nlohmann::ordered_json as_json(const BenchRow& row, const BenchTimes& times, int rounds) {
  nlohmann::ordered_json stages;
  for (const auto& [name, ms] : times.ms) {
    stages[name] = {{"p50", quantile(ms, 0.5)}, {"p99", quantile(ms, 0.99)}, {"least", quantile(ms, 0)}};
  }
  return {
      {"name", row.name},       {"input", row.input},
      {"picture", row.picture}, {"settings", fmt::format("{} {} {}", row.method, row.settings, row.changes)},
      {"rounds", rounds},       {"surface_share", times.surface_share},
      {"stages_ms", stages}};
}

/// The columns of the table in their order. The JSON report has all times.
constexpr const char* kColumns[] = {"new_volume",  "cast",         "filter",        "light",
                                    "finish",      "read_back",    "camera",        "frame",
                                    "light_moved", "whole_volume", "whole_prepare", "cast_unskipped"};

void print_head() {
  fmt::print("ms, medians\n{:<22}", "");
  for (const char* const name : kColumns) fmt::print(" {:>14}", name);
  fmt::print("\n");
}

void print_row(const BenchRow& row, const BenchTimes& times) {
  fmt::print("{:<22}", row.name);
  for (const char* const name : kColumns) fmt::print(" {:>14.2f}", quantile(times.ms.at(name), 0.5));
  fmt::print("\n");
  std::fflush(stdout);
}

/// The row with exactly this name, or else all rows whose name contains it. Error, kNotFound: no row.
Result<std::vector<BenchRow>> chosen_rows(std::string_view only) {
  std::vector<BenchRow> chosen;
  for (const BenchRow& row : bench_rows()) {
    if (row.name == only) return std::vector{row};
    if (row.name.find(only) != std::string_view::npos) chosen.push_back(row);
  }
  if (chosen.empty()) {
    return Error{ErrorCode::kNotFound, fmt::format("no row has {} in its name, expected one as {}", only,
                                                   bench_rows().front().name)};
  }
  return chosen;
}

Result<std::vector<BenchRow>> chosen_rows(std::span<const std::string_view> names) {
  std::vector<BenchRow> rows;
  for (const std::string_view name : names) {
    const auto chosen = chosen_rows(name);
    if (!chosen) return chosen.error();
    std::ranges::copy(*chosen, std::back_inserter(rows));
  }
  return rows;
}

/// The source of --input as a row, or else the rows of --only.
Result<std::vector<BenchRow>> chosen_rows(const BenchOptions& options) {
  std::vector<BenchRow> rows{
      BenchRow{.name = "input", .input = options.input, .geometry_path = options.geometry_path}};
  if (options.input.empty()) {
    auto chosen = chosen_rows(std::string_view(options.only));
    if (!chosen) return chosen.error();
    rows = std::move(*chosen);
  }
  for (BenchRow& row : rows) row.changes = options.changes;
  return rows;
}

Result<RenderDevice> open_bench_device(const BenchOptions& options) {
  DeviceOptions device = live_device_options();
  device.access = options.access;
  if (options.one_device) device.own_light_device = false;
  device.instance.processor_as_gpu = options.as_gpu;
  return open_device(options.gpu, device);
}

Result<void> bench(const BenchOptions& options) {
  const auto device = open_bench_device(options);
  if (!device) return device.error();
  nlohmann::ordered_json report = report_of(*device);
  report["rows"] = nlohmann::ordered_json::array();
  const auto rows = chosen_rows(options);
  if (!rows) return rows.error();
  ProgressLine progress;
  for (const BenchRow& row : *rows) {
    const std::size_t done = report["rows"].size();
    progress.show_step(fmt::format("measures row {} of {}", done + 1, rows->size()), done, rows->size());
    const auto times = run_bench_row(*device, row, options.count);
    if (!times) return times.error();
    progress.clear();
    report["rows"].push_back(as_json(row, *times, options.count));
    if (!options.json && report["rows"].size() == 1) print_head();
    if (!options.json) print_row(row, *times);
  }
  if (options.json) fmt::print("{}\n", json_text(report, 1));
  return {};
}

Result<void> bench_pipeline(const BenchOptions& options) {
  const auto device = open_bench_device(options);
  if (!device) return device.error();
  nlohmann::ordered_json report = report_of(*device);
  report["mechanism"] = pipeline_mechanism(*device);
  report["blocks"] = options.count;
  report["volumes_a_block"] = options.volumes;
  report["rows"] = nlohmann::ordered_json::array();
  if (!options.json) {
    fmt::print("{}, {}; medians of {} blocks of {} volumes each way, in turn\n", device->name(),
               pipeline_mechanism(*device), options.count, options.volumes);
  }
  const auto rows =
      options.only.empty() && options.input.empty() ? chosen_rows(pipeline_rows()) : chosen_rows(options);
  if (!rows) return rows.error();
  ProgressLine progress;
  for (const BenchRow& row : *rows) {
    const std::size_t done = report["rows"].size();
    progress.show_step(fmt::format("measures row {} of {}", done + 1, rows->size()), done, rows->size());
    const auto times = run_bench_pipeline(
        *device, row, {.blocks = options.count, .volumes = options.volumes, .sweep_ms = options.sweep_ms});
    if (!times) return times.error();
    progress.clear();
    report["rows"].push_back(as_json(row, *times));
    if (!options.json) print_pipeline(row, *times);
    if (options.trace.empty()) continue;
    if (auto written = replace_file(options.trace, times->last_block); !written) return written;
  }
  if (options.json) fmt::print("{}\n", json_text(report, 1));
  return {};
}

Result<void> bench_rate(const BenchOptions& options) {
  const auto device = open_bench_device(options);
  if (!device) return device.error();
  nlohmann::ordered_json report = report_of(*device);
  report["offered_a_second"] = options.offered_hz;
  report["blocks"] = options.count;
  report["volumes_a_block"] = options.rate_volumes;
  report["rows"] = nlohmann::ordered_json::array();
  const auto rows =
      options.only.empty() && options.input.empty() ? chosen_rows(rate_rows()) : chosen_rows(options);
  if (!rows) return rows.error();
  if (!options.json) {
    fmt::print(
        "{}; {:g} sweeps a second, newest first; medians of {} blocks of {} volumes each way, in turn\n",
        device->name(), options.offered_hz, options.count, options.rate_volumes);
    print_rates_head();
  }
  ProgressLine progress;
  for (const BenchRow& row : *rows) {
    const std::size_t done = report["rows"].size();
    progress.show_step(fmt::format("measures row {} of {}", done + 1, rows->size()), done, rows->size());
    const auto rates = run_bench_rate(
        *device, row,
        {.offered_hz = options.offered_hz, .blocks = options.count, .volumes = options.rate_volumes});
    if (!rates) return rates.error();
    progress.clear();
    report["rows"].push_back(as_json(row, *rates));
    if (!options.json) print_rates(row, *rates);
  }
  if (options.json) fmt::print("{}\n", json_text(report, 1));
  return {};
}

Result<void> bench_memory(const BenchOptions& options) {
  MemoryLedger ledger;
  const auto device = open_bench_device(options);
  if (!device) return device.error();
  ledger.note("device");
  BenchOptions one_row = options;
  if (one_row.only.empty()) one_row.only = "r1/paper";
  const auto rows = chosen_rows(one_row);
  if (!rows) return rows.error();
  const BenchRow& row = rows->front();
  nlohmann::ordered_json report = report_of(*device);
  report["name"] = row.name;
  report["input"] = row.input;
  report["held"] = nlohmann::ordered_json::array();
  if (!options.json) fmt::print("{}: MB\n   volumes   resident        own  ring of 4\n", row.name);
  const auto report_held = [&](const HeldMemory& held) {
    report["held"].push_back(as_json(held));
    if (!options.json) print_held(held);
  };
  const auto done =
      run_bench_memory(*device, row, static_cast<std::uint64_t>(options.memory_volumes), ledger, report_held);
  if (!done) return done.error();
  std::vector<MemoryPart> parts = ledger.parts();
  std::ranges::copy(file_pages(), std::back_inserter(parts));
  report["parts"] = as_json(parts);
  if (!options.json) print_parts(parts);
  if (options.json) fmt::print("{}\n", json_text(report, 1));
  return {};
}

nlohmann::ordered_json as_json(const ScaleCurve& curve) {
  nlohmann::ordered_json points = nlohmann::ordered_json::array();
  for (const ScalePoint& point : curve.points)
    points.push_back({{"name", point.name}, {"amount", point.amount}, {"ms", point.ms}});
  return {{"amount", curve.amount},
          {"columns", curve.columns},
          {"points", points},
          {"exponents", curve.exponents}};
}

void print_curve(const ScaleCurve& curve) {
  constexpr int kNameWidth = 28;
  fmt::print("{:<{}}", curve.amount, kNameWidth);
  for (const std::string& column : curve.columns) fmt::print(" {:>16}", column);
  fmt::print("\n");
  for (const ScalePoint& point : curve.points) {
    fmt::print("{:<{}}", point.name, kNameWidth);
    for (const double ms : point.ms) fmt::print(" {:>16.2f}", ms);
    fmt::print("\n");
  }
  fmt::print("{:<{}}", "  exponent", kNameWidth);
  for (const double exponent : curve.exponents) fmt::print(" {:>16.2f}", exponent);
  fmt::print("\n\n");
  std::fflush(stdout);
}

Result<void> bench_scale(const BenchOptions& options) {
  const auto device = open_bench_device(options);
  if (!device) return device.error();
  nlohmann::ordered_json report = report_of(*device);
  report["rounds"] = options.count;
  report["curves"] = nlohmann::ordered_json::array();
  if (!options.json)
    fmt::print("{}; r1/paper in other sizes, ms, medians of {} rounds\n\n", device->name(), options.count);
  const auto done = run_bench_scale(*device, options.count, [&](const ScaleCurve& curve) {
    report["curves"].push_back(as_json(curve));
    if (!options.json) print_curve(curve);
  });
  if (!done) return done.error();
  if (options.json) fmt::print("{}\n", json_text(report, 1));
  return {};
}

nlohmann::ordered_json as_json(const MachineLimits& machine) {
  return {{"processors", machine.processors}, {"vectors", machine.vectors},
          {"gigahertz", machine.gigahertz},   {"read_gb_s", machine.read_gb_s},
          {"gather_ns", machine.gather_ns},   {"far_gather_ns", machine.far_gather_ns},
          {"gflop_s", machine.gflop_s}};
}

void print_machine(const RenderDevice& device, const MachineLimits& machine) {
  fmt::print("{}\n{} processors of {:.1f} GHz with {}\n", device.name(), machine.processors,
             machine.gigahertz, machine.vectors);
  fmt::print("together:  read {:.0f} GB/s, multiply and add {:.0f} GFlop/s\n", machine.read_gb_s,
             machine.gflop_s);
  fmt::print("each:      gather a word in {:.2f} ns in the first cache, in {:.2f} ns anywhere in 16 MB\n",
             machine.gather_ns, machine.far_gather_ns);
}

nlohmann::ordered_json as_json(const BenchRow& row, const RowLimits& limits) {
  nlohmann::ordered_json passes = nlohmann::ordered_json::array();
  for (const PassLimit& pass : limits.passes) {
    passes.push_back({{"pass", pass.pass},
                      {"ms", pass.ms},
                      {"items", pass.items},
                      {"item", pass.item},
                      {"ns_per_item_and_processor", pass.item_ns},
                      {"cycles_per_item_and_processor", pass.item_cycles},
                      {"bytes_per_item", pass.item_bytes},
                      {"memory_ms", pass.memory_ms},
                      {"gather_ms", pass.gather_ms},
                      {"times_the_least", pass.times_the_least()}});
  }
  return {
      {"name", row.name}, {"input", row.input}, {"sampled_share", limits.sampled_share}, {"passes", passes}};
}

void print_limits(const BenchRow& row, const RowLimits& limits) {
  fmt::print("\n{}: {}\n", row.name,
             limits.sampled_share > 0
                 ? fmt::format("{:.1f} % of the samples of a cast without skipping are read",
                               100 * limits.sampled_share)
                 : "the cast reads no samples");
  constexpr std::string_view kRow = "{:<10} {:>20} {:>8} {:>10} {:>10} {:>10}   {:>10} {:>10} {:>10}\n";
  fmt::print(kRow, "", "", "measured", "ns", "cycles", "bytes", "by memory", "by gather", "times");
  fmt::print(kRow, "pass", "work", "ms", "per item", "per item", "per item", "ms", "ms", "the least");
  const auto figure = [](double value) {
    return value > 0 ? fmt::format("{:.3g}", value) : std::string("-");
  };
  for (const PassLimit& pass : limits.passes) {
    const std::string work = fmt::format("{:.3g} M {:<7}", static_cast<double>(pass.items) / 1e6, pass.item);
    fmt::print(kRow, pass.pass, work, figure(pass.ms), figure(pass.item_ns), figure(pass.item_cycles),
               figure(pass.item_bytes), figure(pass.memory_ms), figure(pass.gather_ms),
               figure(pass.times_the_least()));
  }
  std::fflush(stdout);
}

Result<void> bench_limit(const BenchOptions& options) {
  const auto device = open_bench_device(options);
  if (!device) return device.error();
  if (device->gpu->candidate().kind != kProcessorKind) {
    return Error{
        ErrorCode::kUnsupported,
        fmt::format("{} is no processor, expected one: the limits measured are those of the processors",
                    device->name())};
  }
  BenchOptions usual = options;
  if (usual.only.empty() && usual.input.empty()) usual.only = "r1/paper";
  const auto rows = chosen_rows(usual);
  if (!rows) return rows.error();
  // A file that cannot be read is found before seconds of measuring.
  if (!usual.input.empty()) {
    if (const auto work = BenchWork::create(rows->front(), 1); !work) return work.error();
  }
  const MachineLimits machine = measure_machine_limits();
  nlohmann::ordered_json report = report_of(*device);
  report["machine"] = as_json(machine);
  report["rounds"] = options.count;
  report["rows"] = nlohmann::ordered_json::array();
  if (!options.json) print_machine(*device, machine);
  for (const BenchRow& row : *rows) {
    const auto limits = run_bench_limit(*device, machine, row, options.count);
    if (!limits) return limits.error();
    report["rows"].push_back(as_json(row, *limits));
    if (!options.json) print_limits(row, *limits);
  }
  if (options.json) {
    fmt::print("{}\n", json_text(report, 1));
    return {};
  }
  fmt::print(
      "\nTimes per item are of one processor. The least time is the longer one by memory and by gather: what "
      "is computed\n"
      "with these bytes and words comes in addition. Figures of a busy machine or of few rounds are too "
      "high.\n");
  return {};
}

void add_device_options(CLI::App& command, BenchOptions& options) {
  command.add_option("--gpu", options.gpu, "GPU to use, by a part of its name")->type_name("NAME");
  add_named_option<std::optional<BufferAccess>, BufferAccess>(
      command, "--buffers", options.access,
      {{"texels", BufferAccess::kTexels}, {"storage", BufferAccess::kStorage}},
      "How shaders read buffers: texels or storage (default: the faster one on this device)");
  command.add_flag(
      "--one-device", options.one_device,
      "On a CPU without AVX2, run all passes on one device instead of passes 2 and 3 on a second one");
  command.add_flag("--as-gpu", options.as_gpu,
                   "Treat a driver that renders on the CPU as a GPU, so that shaders run all passes");
  command.add_flag("--json", options.json, "Print the report as JSON");
}

void add_options(CLI::App& command, BenchOptions& options) {
  command
      .add_option("--only", options.only,
                  "Measure only the row with this name, or rows whose name contains it")
      ->type_name("NAME");
  command
      .add_option("--input", options.input, "Measure the default scene of this source instead of the rows")
      ->excludes("--only")
      ->type_name("SOURCE");
  command.add_option("--geometry", options.geometry_path, "TOML file with the geometry of the recording")
      ->needs("--input")
      ->type_name("FILE");
  command
      .add_option("--set", options.changes,
                  "Scene fields to set, such as \"detector.place=refined shadow.coefficient=1\"")
      ->type_name("FIELDS");
  add_device_options(command, options);
}

}  // namespace

Command add_bench_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("bench", "Measure rendering time");
  CLI::App* const pipeline =
      command->add_subcommand("pipeline", "Measure the gain from overlapping the passes of several volumes");
  CLI::App* const rate = command->add_subcommand(
      "rate", "Measure how many volumes a second become pictures, and how many are dropped");
  CLI::App* const memory = command->add_subcommand("memory", "Measure memory use, and whether it grows");
  CLI::App* const scale = command->add_subcommand(
      "scale", "Measure how the cost grows with pixels, voxels, frames and private views");
  CLI::App* const limit = command->add_subcommand(
      "limit", "Compare each pass with what the processors can do at most (default row: r1/paper)");
  const auto options = std::make_shared<BenchOptions>();
  for (const auto& [app, what] :
       {std::pair(command, "Number of rounds per row"), std::pair(limit, "Number of rounds per row"),
        std::pair(pipeline, "Number of blocks, pipelined and serial each"),
        std::pair(rate, "Number of blocks, at once and frame by frame each")}) {
    add_options(*app, *options);
    app->add_option("--count", options->count, what)
        ->capture_default_str()
        ->check(CLI::Range(1, 100000))
        ->type_name("N");
  }
  pipeline->add_option("--volumes", options->volumes, "Number of volumes per block")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  pipeline
      ->add_option("--sweep", options->sweep_ms,
                   "Duration of a sweep of the live probe (default: 0.75 of the time that a volume takes)")
      ->check(CLI::Range(1.0, 60000.0))
      ->type_name("MS");
  pipeline
      ->add_option("--trace", options->trace,
                   "Write a timeline of the passes in the last live block as an SVG; with several "
                   "rows that of the last row")
      ->type_name("FILE");
  rate->add_option("--offered", options->offered_hz, "Sweeps a second that the source delivers")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 1000.0))
      ->type_name("HZ");
  rate->add_option("--volumes", options->rate_volumes, "Number of volumes per block")
      ->capture_default_str()
      ->check(CLI::Range(2, 10000))
      ->type_name("N");
  add_device_options(*scale, *options);
  scale->add_option("--count", options->count, "Number of rounds per point")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  add_options(*memory, *options);
  memory->add_option("--volumes", options->memory_volumes, "Number of volumes to render")
      ->capture_default_str()
      ->check(CLI::Range(10, 1'000'000))
      ->type_name("N");
  return [options, pipeline, rate, memory, scale, limit]() {
    if (pipeline->parsed()) return bench_pipeline(*options);
    if (rate->parsed()) return bench_rate(*options);
    if (limit->parsed()) return bench_limit(*options);
    if (scale->parsed()) return bench_scale(*options);
    return memory->parsed() ? bench_memory(*options) : bench(*options);
  };
}

}  // namespace fanlight
