// SPDX-License-Identifier: Apache-2.0
// Prints a table of the errors between rendered and known surfaces. Fails if a figure does not meet its
// demand.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <regex>

#include "tests/accuracy/depth_rig.hpp"
#include "tests/accuracy/measurements.hpp"

namespace fanlight::test {
namespace {

struct Options {
  std::string rows = ".";
  std::string gpu;
  std::vector<std::string> changes;
  bool json = false;
};

/// Applies NAME=VALUE. Only fields that move neither the camera nor the rays are accepted, so that the truth
/// of a pixel does not change. Throws std::runtime_error.
void apply(const std::string& change, Scene& scene) {
  const std::size_t equals = change.find('=');
  const std::string name = change.substr(0, equals);
  const SceneField* const field = find_scene_field(name);
  const bool free = name.starts_with("speckle.") || name.starts_with("detector.") ||
                    name.starts_with("filter.") || name == "light.normals" || name == "rays.window";
  if (equals == std::string::npos || field == nullptr || !free) {
    throw std::runtime_error(fmt::format(
        "--set {} names no such field, expected speckle., detector. or filter.NAME=VALUE, light.normals, or "
        "rays.window",
        change));
  }
  if (auto set = set_field(scene, *field, std::string_view(change).substr(equals + 1)); !set)
    throw std::runtime_error(set.error().message);
}

std::vector<FigureBlock> measured(const Options& options) {
  BareGpu bare(options.gpu);
  const std::regex rows(options.rows);
  const Workbench bench{.gpu = bare,
                        .wants = [&](const std::string& row) { return std::regex_search(row, rows); },
                        .change =
                            [&](Scene& scene) {
                              for (const std::string& change : options.changes) apply(change, scene);
                            }};
  std::vector<FigureBlock> blocks = measure_small_fans(bench);
  blocks.push_back(measure_scanned_scenes(bench));
  blocks.push_back(measure_fluid_volumes(bench));
  blocks.push_back(measure_distances(bench));
  blocks.push_back(measure_steady_sequences(bench));
  blocks.push_back(measure_thin_interface(bench));
  blocks.push_back(measure_wombs(bench));
  blocks.push_back(measure_found_surfaces(bench));
  blocks.push_back(measure_relighting(bench));
  blocks.push_back(measure_reference_work(bench));
  return blocks;
}

int run(const Options& options) {
  const std::vector<FigureBlock> blocks = measured(options);
  const bool any = std::ranges::any_of(blocks, [](const FigureBlock& block) { return !block.rows.empty(); });
  if (!any) {
    fmt::print(stderr, "accuracy: no row's name holds \"{}\"\n", options.rows);
    return 1;
  }
  const std::vector<std::string> failed = failures(blocks);
  fmt::print("{}\n", options.json ? as_json(blocks) : as_text(blocks));
  for (const std::string& failure : failed) fmt::print(stderr, "not reached: {}\n", failure);
  return failed.empty() ? 0 : 1;
}

}  // namespace
}  // namespace fanlight::test

int main(int count, char** arguments) {
  fanlight::test::Options options;
  CLI::App program("Accuracy of the surfaces shown, against surfaces that are known");
  program.add_option("--rows", options.rows, "Only rows whose name holds this, such as clean/sphere")
      ->type_name("REGEX");
  program.add_option("--gpu", options.gpu, "GPU to use, by a part of its name")->type_name("NAME");
  program.add_option("--set", options.changes, "A field of the default scene to try otherwise")
      ->type_name("NAME=VALUE");
  program.add_flag("--json", options.json, "Print the figures as JSON");
  CLI11_PARSE(program, count, arguments);
  try {
    return fanlight::test::run(options);
  } catch (const std::exception& failure) {
    fmt::print(stderr, "accuracy: {}\n", failure.what());
    return 1;
  }
}
