#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <nlohmann/json.hpp>

#include "renderer/gpu.hpp"
#include "server/bench_run.hpp"
#include "server/commands.hpp"

namespace fanlight {

namespace {

struct BenchOptions {
  std::string only;
  int count = 9;
  std::string gpu;
  bool json = false;
};

nlohmann::ordered_json as_json(const BenchRow& row, const BenchTimes& times, int rounds) {
  nlohmann::ordered_json stages;
  for (const auto& [name, ms] : times.ms) {
    stages[name] = {{"p50", quantile(ms, 0.5)}, {"p99", quantile(ms, 0.99)}, {"least", quantile(ms, 0)}};
  }
  return {{"name", row.name},         {"input", row.input}, {"picture", row.picture},
          {"settings", row.settings}, {"rounds", rounds},   {"surface_share", times.surface_share},
          {"stages_ms", stages}};
}

void print_row(const BenchRow& row, const BenchTimes& times) {
  fmt::print("{:<22}", row.name);
  for (const auto* name : {"new_volume", "cast", "filter", "light", "finish", "read_back", "camera",
                           "light_moved", "whole_volume", "whole_prepare", "cast_unskipped"}) {
    fmt::print(" {:>9.2f}", quantile(times.ms.at(name), 0.5));
  }
  fmt::print("\n");
  std::fflush(stdout);
}

Result<void> bench(const BenchOptions& options) {
  const auto instance = GpuInstance::create({});
  if (!instance) return instance.error();
  const auto gpu = Gpu::create(**instance, options.gpu);
  if (!gpu) return gpu.error();
  nlohmann::ordered_json report = {{"device", (*gpu)->candidate().name},
                                   {"rows", nlohmann::ordered_json::array()}};
  for (const BenchRow& row : bench_rows()) {
    if (row.name.find(options.only) == std::string_view::npos) continue;
    const auto times = run_bench_row(**gpu, row, options.count);
    if (!times) return times.error();
    report["rows"].push_back(as_json(row, *times, options.count));
    if (!options.json) print_row(row, *times);
  }
  if (options.json) fmt::print("{}\n", report.dump(1));
  return {};
}

}  // namespace

Command add_bench_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("bench", "Measures how long pictures take");
  const auto options = std::make_shared<BenchOptions>();
  command->add_option("--only", options->only, "Rows whose name contains this")->type_name("NAME");
  command->add_option("--count", options->count, "Rounds of each row")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000))
      ->type_name("N");
  command->add_option("--gpu", options->gpu, "Part of the name of the GPU to use")->type_name("NAME");
  command->add_flag("--json", options->json, "Print the report as JSON");
  return [options]() { return bench(*options); };
}

}  // namespace fanlight
