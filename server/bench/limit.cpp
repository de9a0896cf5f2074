// SPDX-License-Identifier: Apache-2.0
#include "server/bench/limit.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "renderer/volume/render_workers.hpp"
#include "server/bench/rig.hpp"
#include "server/bench/run.hpp"
#include "server/bench/work.hpp"

namespace fanlight {

namespace {

// A packed word holds three new rows of a column (shaders/prepare_constants.h); a block of 4 x 4 pixels has a
// word of bounds.
constexpr double kPackedBytes = 4.0 / 3;
constexpr double kBoundsBytes = 4.0 / 16;
// The two columns of two frames around a sample (shaders/fan_volume.h).
constexpr double kGathersOfSample = 4;
// Depth, colour with certainty, and picture have four bytes a pixel each.
constexpr double kPixelBytes = 4;

/// Number of samples that a whole cast reads. It is counted by another shader, so its time is not taken.
Result<std::uint64_t> count_samples(const RenderDevice& device, BenchWork& work, Skipping skipping) {
  BenchRig rig(device, work);
  if (auto started = rig.start(skipping, Counting::kOn); !started) return started.error();
  if (auto done = rig.whole_volume(); !done) return done.error();
  return rig.renderer().read_sample_count();
}

void set_least(PassLimit& pass, const MachineLimits& machine, std::size_t threads) {
  if (pass.items == 0) return;
  const auto items = static_cast<double>(pass.items);
  const auto processors = static_cast<double>(threads);
  pass.item_ns = 1e6 * pass.ms * processors / items;
  pass.item_cycles = pass.item_ns * machine.gigahertz;
  pass.memory_ms = items * pass.item_bytes / machine.read_gb_s / 1e6;
  pass.gather_ms = items * pass.item_gathers * machine.gather_ns / processors / 1e6;
}

}  // namespace

Result<RowLimits> run_bench_limit(const RenderDevice& device, const MachineLimits& machine,
                                  const BenchRow& row, int rounds) {
  constexpr std::uint32_t kVolumes = 3;
  auto work = BenchWork::create(row, kVolumes);
  if (!work) return work.error();
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  std::array<std::vector<double>, kStages> times_ms;
  for (int round = 0; round <= rounds; ++round) {
    if (auto done = rig.whole_volume(); !done) return done.error();
    for (std::size_t stage = 0; round > 0 && stage < kStages; ++stage)
      times_ms[stage].push_back(rig.picture().stamp.stage_ms[stage]);
  }
  const auto samples = count_samples(device, *work, Skipping::kOn);
  if (!samples) return samples.error();
  const auto all_samples = count_samples(device, *work, Skipping::kOff);
  if (!all_samples) return all_samples.error();

  const FanGeometry& geometry = work->volumes.description().geometry;
  const std::uint64_t voxels = geometry.frame_bytes() * rig.picture().stamp.volume.frames;
  const std::uint64_t pixels = rig.picture().rgba.size() / 4;
  // A ray that reads nothing still writes its pixel; the volume is read once at most.
  const double all_cast_bytes =
      static_cast<double>(voxels) * kPackedBytes + 2 * kPixelBytes * static_cast<double>(pixels);
  const double cast_bytes = *samples > 0 ? all_cast_bytes / static_cast<double>(*samples) : 0;
  struct Work {
    Stage stage;
    std::uint64_t items;
    const char* item;
    double bytes;
    double gathers;
  };
  const Work passes[] = {{Stage::kPrepare, voxels, "voxels", 1 + kPackedBytes + kBoundsBytes, 0},
                         {Stage::kCast, *samples, "samples", cast_bytes, kGathersOfSample},
                         {Stage::kFilter, pixels, "pixels", 2 * kPixelBytes, 0},
                         {Stage::kLight, pixels, "pixels", 3 * kPixelBytes, 0},
                         {Stage::kFinish, pixels, "pixels", 2 * kPixelBytes, 0},
                         // The depth map. The picture could be finished where it is read, as on a processor.
                         {Stage::kReadBack, pixels, "pixels", 2 * kPixelBytes, 0}};
  RowLimits limits{.passes = {},
                   .sampled_share = *all_samples > 0
                                        ? static_cast<double>(*samples) / static_cast<double>(*all_samples)
                                        : 0};
  for (const Work& each : passes) {
    const auto stage = static_cast<std::size_t>(each.stage);
    PassLimit& pass = limits.passes.emplace_back(PassLimit{.pass = std::string(kStageNames[stage]),
                                                           .ms = quantile(times_ms[stage], 0.5),
                                                           .items = each.items,
                                                           .item = each.item,
                                                           .item_bytes = each.bytes,
                                                           .item_gathers = each.gathers});
    const bool is_prepared = each.stage == Stage::kPrepare;
    set_least(
        pass, machine,
        is_prepared ? std::min(machine.processors, RenderWorkers::usual_threads()) : machine.processors);
  }
  return limits;
}

}  // namespace fanlight
