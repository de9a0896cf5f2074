// SPDX-License-Identifier: Apache-2.0
// The cost of the filters of pass 2 by the size of their window: filters the depth map of the phantom's face
// with each size in turn, in one run.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <map>

#include "acquisition/phantom/phantom_source.hpp"
#include "renderer/renderer.hpp"

namespace fanlight {
namespace {

constexpr std::array kSizes = {3, 7, 13, 19, 25, 31};
constexpr std::array kKinds = {DepthFilter::kMean, DepthFilter::kGaussian, DepthFilter::kEdgePreserving};
constexpr std::array kKindNames = {"mean", "gaussian", "edge-preserving"};

[[noreturn]] void fail(const Error& error) {
  fmt::print(stderr, "filter_cost: {}\n", error.message);
  std::exit(1);
}

template <typename T>
T required(Result<T> result) {
  if (!result) fail(result.error());
  return std::move(result).value();
}

double median(std::vector<double> values) {
  std::ranges::nth_element(values, values.begin() + values.size() / 2);
  return values[values.size() / 2];
}

Picture next_picture(Renderer& renderer) {
  Picture picture;
  for (;;) {
    if (auto advanced = renderer.advance(); !advanced) fail(advanced.error());
    if (renderer.collect(picture)) return picture;
    if (auto waited = renderer.wait(1'000'000'000); !waited) fail(waited.error());
  }
}

void run(int rounds) {
  const auto source = required(PhantomSource::create({.pace = PhantomSource::Pace::kUnpaced}));
  const SourceDescription& description = source->description();
  Volume volume(description.geometry, description.frames_per_volume);
  while (!volume.full()) {
    const auto frame = source->next_frame({});
    source->read_pixels(volume.next_frame_pixels(), {});
    volume.add_frame(**frame);
  }
  volume.sort_by_angle();
  volume.stamp().volume_id = 1;

  const auto instance = required(GpuInstance::create({}));
  const auto gpu = required(Gpu::create(*instance, ""));
  RenderCounters counters;
  NumberedScene shown{
      .revision = 1,
      .scene = scene_for(description.geometry, description.first_angle_rad, description.last_angle_rad)};
  // The filter only: the cost of finding islands and holes does not depend on it.
  shown.scene.filter.islands = 1;
  shown.scene.filter.holes = 1;
  const auto renderer = required(Renderer::create({.size = {},
                                                   .geometry = description.geometry,
                                                   .first_angle_rad = description.first_angle_rad,
                                                   .last_angle_rad = description.last_angle_rad,
                                                   .frame_capacity = description.frames_per_volume},
                                                  {.gpu = *gpu, .counters = counters}, shown));
  if (auto loaded = renderer->load(volume); !loaded) fail(loaded.error());
  next_picture(*renderer);

  std::map<std::pair<std::size_t, int>, std::vector<double>> times_ms;
  // One more round than counted: the first one builds pipelines.
  for (int round = 0; round <= rounds; ++round) {
    for (const int size : kSizes) {
      for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
        shown.scene.filter.kind = kKinds[kind];
        shown.scene.filter.size_mm = 0;
        shown.scene.filter.size = size;
        ++shown.revision;
        renderer->show(shown);
        const Picture picture = next_picture(*renderer);
        if (round > 0) {
          times_ms[{kind, size}].push_back(picture.stamp.stage_ms[static_cast<std::size_t>(Stage::kFilter)]);
        }
      }
    }
  }
  fmt::print("{} x {} pixels on {}, medians of {}, ms\n{:<16}", 512, 512, gpu->candidate().name, rounds,
             "size");
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
