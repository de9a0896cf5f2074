// SPDX-License-Identifier: Apache-2.0
// The cost of the filters of pass 2 by the size of their window: filters the depth map of the phantom's face
// with each size in turn, in one run.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <map>

#include "tests/bench/still_renderer.hpp"

namespace fanlight {
namespace {

constexpr std::array kSizes = {3, 7, 13, 19, 25, 31};
constexpr std::array kKinds = {DepthFilter::kMean, DepthFilter::kGaussian, DepthFilter::kEdgePreserving};
constexpr std::array kKindNames = {"mean", "gaussian", "edge-preserving"};

void run(int rounds) {
  StillRenderer renderer(PhantomSource::Config{});
  Scene scene = renderer.scene();
  // The filter only: the cost of finding islands and holes does not depend on it.
  scene.filter.islands = 1;
  scene.filter.holes = 1;

  std::map<std::pair<std::size_t, int>, std::vector<double>> times_ms;
  // One more round than counted: the first one builds pipelines.
  for (int round = 0; round <= rounds; ++round) {
    for (const int size : kSizes) {
      for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
        scene.filter.kind = kKinds[kind];
        scene.filter.size_mm = 0;
        scene.filter.size = size;
        const Picture picture = renderer.show(scene);
        if (round > 0) times_ms[{kind, size}].push_back(stage_ms(picture, Stage::kFilter));
      }
    }
  }
  fmt::print("{} x {} pixels on {}, medians of {}, ms\n{:<16}", 512, 512, renderer.device(), rounds, "size");
  for (const int size : kSizes) fmt::print("{:>8}", size);
  fmt::print("  slowest / fastest\n");
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
    fmt::print("{:<16}", kKindNames[kind]);
    double slowest_ms = 0;
    double fastest_ms = HUGE_VAL;
    for (const int size : kSizes) {
      const double ms = median(times_ms[{kind, size}]);
      slowest_ms = std::max(slowest_ms, ms);
      fastest_ms = std::min(fastest_ms, ms);
      fmt::print("{:>8.2f}", ms);
    }
    fmt::print("{:>10.2f}\n", slowest_ms / fastest_ms);
  }
}

}  // namespace
}  // namespace fanlight

int main(int count, char** arguments) {
  int rounds = 25;
  CLI::App program("What the filters of the depth map cost, by the size of their window");
  program.add_option("--rounds", rounds, "How often each is timed")->check(CLI::Range(1, 1000));
  CLI11_PARSE(program, count, arguments);
  fanlight::run(rounds);
  return 0;
}
