// SPDX-License-Identifier: Apache-2.0
// Long runs: a probe that is unplugged a thousand times, that sends at full speed for minutes, or that sends
// only noise. Prints figures; exits with 1 where a requirement fails. Times are printed and not checked.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <thread>
#include <vector>

#include "proto/base/clock.hpp"
#include "tests/usb/acquisition_fixture.hpp"
#include "tests/usb/resources.hpp"

namespace {

using namespace fanlight;
using namespace fanlight::test;

struct Options {
  int cycles = 1000;
  bool no_udev = false;
  double seconds = 600;
  double mb_per_s = 100;
};

void require(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error(what);
}

struct Spread {
  double median;
  double p99;
  double largest;
};
Spread spread_of(std::vector<double> values) {
  std::ranges::sort(values);
  return {values[values.size() / 2], values[values.size() * 99 / 100], values.back()};
}

/// 64 x 64 pixels, 10 frames a volume, 400 frames a second: a sweep takes 25 ms.
ProbeModel::Config small_probe() {
  return {.frame_rate_hz = 400,
          .frames_per_volume = 10,
          .columns = 64,
          .rows = 64,
          .room_frames = 100,
          .prepared = true};
}

EmulatedBus::Udev udev_of(const Options& options) {
  return options.no_udev ? EmulatedBus::Udev::kOff : EmulatedBus::Udev::kOn;
}

void print_resources(const char* when, const Resources& held) {
  fmt::print("{}: {} files, {} threads, {:.1f} MB resident, {:.2f} MB of heap\n", when, held.files,
             held.threads, held.resident_mb, held.heap_mb);
}

/// Unplugs with pending transfers and plugs in again, repeatedly.
void run_cycles(const Options& options) {
  AcquisitionFixture fixture({.model = small_probe(),
                              .udev = udev_of(options),
                              .reads = {.transfers = 16, .transfer_bytes = 16 << 10}});
  fixture.start();
  const auto volumes = [&fixture] { return fixture.ring().counters().volumes_published.value(); };
  const auto next_volume = [&] {
    const std::uint64_t before = volumes();
    require(wait_until([&] { return volumes() > before; }), "no volume came");
  };
  std::vector<double> lost_ms;
  std::vector<double> back_ms;
  Resources before{};
  // The first cycles fill caches and pools of libusb, the emulator and the allocator.
  const int warm_up = std::max(10, options.cycles / 5);
  for (int cycle = 0; cycle < warm_up + options.cycles; ++cycle) {
    next_volume();
    if (cycle == warm_up) before = Resources::now();
    const std::uint64_t losses = fixture.counters().probes_lost.value();
    const std::int64_t unplugged_ns = now_ns();
    fixture.probe().unplug();
    require(wait_until([&] { return fixture.counters().probes_lost.value() > losses; }),
            "the loss was not seen");
    lost_ms.push_back(static_cast<double>(now_ns() - unplugged_ns) / 1e6);
    require(fixture.frames().sum_holds(), "frames are not accounted for");
    const std::int64_t plugged_ns = now_ns();
    fixture.probe().plug();
    next_volume();
    back_ms.push_back(static_cast<double>(now_ns() - plugged_ns) / 1e6);
  }
  const Resources after = Resources::now();
  const Spread lost = spread_of(lost_ms);
  const Spread back = spread_of(back_ms);
  fmt::print("{} cycles {} udev\n", options.cycles, options.no_udev ? "without" : "with");
  fmt::print("unplugged until noticed: median {:.1f} ms, 99 % {:.1f} ms, longest {:.1f} ms\n", lost.median,
             lost.p99, lost.largest);
  fmt::print(
      "plugged in until the first volume (25 ms of sweep): median {:.0f} ms, 99 % {:.0f} ms, longest {:.0f} "
      "ms\n",
      back.median, back.p99, back.largest);
  print_resources("before", before);
  print_resources("after", after);
  fixture.stop();
  require(fixture.frames().sum_holds(), "frames are not accounted for");
  require(after.files <= before.files, "file descriptors were left behind");
  require(after.threads <= before.threads, "threads were left behind");
  // The emulated bus in this process (umockdev) keeps about 4 KB of each plug. In the guest of tests/usb_vm,
  // where the probe is another process, the reader's heap does not grow.
  const double kept_by_the_bus_mb = 0.006 * options.cycles;
  require(after.resident_mb < before.resident_mb + 4 + kept_by_the_bus_mb, "memory was left behind");
}

/// Reads at a rate, and compares the probe's counters with the reader's.
void run_throughput(const Options& options) {
  ProbeModel::Config model{.frames_per_volume = 35, .columns = 512, .rows = 512, .prepared = true};
  model.frame_rate_hz = options.mb_per_s * 1e6 / (512 * 512 + probe::kFrameHeaderBytes);
  AcquisitionFixture fixture({.model = model, .udev = udev_of(options)});
  fixture.start();
  require(wait_until([&] { return fixture.frames().frames_received.value() > 0; }), "no frame came");
  const Resources before = Resources::now();
  const std::int64_t start_ns = now_ns();
  const std::uint64_t start_bytes = fixture.counters().bytes_received.value();
  while (now_ns() - start_ns < static_cast<std::int64_t>(options.seconds * 1e9)) {
    (void)fixture.ring().take();
    require(fixture.frames().sum_holds(), "frames are not accounted for");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const double seconds = static_cast<double>(now_ns() - start_ns) / 1e9;
  const double mb = static_cast<double>(fixture.counters().bytes_received.value() - start_bytes) / 1e6;
  const Resources after = Resources::now();
  const std::uint64_t dropped_before = fixture.probe().counters().frames_dropped;
  fixture.stop();
  const AcquisitionCounters& frames = fixture.frames();
  const RingCounters& ring = fixture.ring().counters();
  const ProbeModel::Counters sent = fixture.probe().counters();
  fmt::print("{:.0f} s at {:.1f} MB/s asked for: {:.1f} MB/s came\n", seconds, options.mb_per_s,
             mb / seconds);
  fmt::print(
      "probe: {} frames taken, {} sent whole, {} dropped for want of room or at the end, {} cut at the end\n",
      sent.frames_taken, sent.frames_sent, sent.frames_dropped, sent.frames_torn);
  fmt::print(
      "host: {} frames received, {} assembled, {} missing, {} cut, {} in incomplete volumes, {} abandoned\n",
      frames.frames_received.value(), frames.frames_assembled.value(), frames.frames_missing.value(),
      frames.frames_cut.value(), frames.frames_in_incomplete_volumes.value(),
      frames.frames_abandoned.value());
  fmt::print("volumes: {} published, {} of them interpolated, {} incomplete, {} taken, {} dropped\n",
             ring.volumes_published.value(), frames.volumes_interpolated.value(),
             frames.volumes_incomplete.value(), ring.volumes_taken.value(), ring.volumes_dropped.value());
  print_resources("before", before);
  print_resources("after", after);
  require(fixture.frames().sum_holds(), "frames are not accounted for");
  require(frames.frames_damaged.value() == 0 && fixture.counters().bytes_skipped.value() == 0,
          "bytes were lost");
  // The difference is the frames in transit when reading stopped.
  const std::uint64_t known = frames.frames_received.value() + frames.frames_missing.value();
  require(known <= sent.frames_taken, "more frames were counted than there were");
  const std::uint64_t unread = sent.frames_taken - known;
  // Frames read ahead when reading stopped, which the probe then dropped.
  const std::uint64_t read_ahead = 96;
  const std::uint64_t on_its_way = sent.frames_dropped - dropped_before + sent.frames_torn + read_ahead;
  fmt::print("on their way at the end: {} frames\n", unread);
  require(unread <= on_its_way, "frames are lost that no one counted");
  require(after.files <= before.files && after.threads <= before.threads,
          "files or threads were left behind");
}

/// Only random bytes from the probe, except briefly after each start of the stream.
void run_random(const Options& options) {
  AcquisitionFixture fixture({.model = small_probe(),
                              .udev = udev_of(options),
                              .reads = {.transfers = 16, .transfer_bytes = 16 << 10}});
  fixture.start();
  const std::int64_t start_ns = now_ns();
  Resources before{};
  std::uint64_t rounds = 0;
  while (now_ns() - start_ns < static_cast<std::int64_t>(options.seconds * 1e9)) {
    // Injected after frames arrive, because a start ends the fault.
    const std::uint64_t frames = fixture.frames().frames_received.value();
    require(wait_until([&] { return fixture.frames().frames_received.value() > frames; }),
            "no frame came after the noise");
    const std::uint64_t restarts = fixture.counters().streams_restarted.value();
    fixture.probe().inject({.kind = FaultKind::kRandom});
    require(wait_until([&] { return fixture.counters().streams_restarted.value() > restarts; }),
            "the stream was not started again");
    require(fixture.frames().sum_holds(), "frames are not accounted for");
    if (++rounds == 3) before = Resources::now();
  }
  const std::uint64_t volumes = fixture.ring().counters().volumes_published.value();
  require(wait_until([&] { return fixture.ring().counters().volumes_published.value() > volumes; }),
          "no volume came after the noise");
  const Resources after = Resources::now();
  fmt::print("{:.1f} MB of noise in {} stretches, all skipped\n",
             static_cast<double>(fixture.counters().bytes_skipped.value()) / 1e6, rounds);
  if (rounds < 4) return;
  print_resources("before", before);
  print_resources("after", after);
  require(after.files <= before.files && after.threads <= before.threads,
          "files or threads were left behind");
  require(after.resident_mb < before.resident_mb + 4, "memory was left behind");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program("Long runs against an emulated probe; to be started with umockdev's library preloaded");
  Options options;
  program.add_flag("--no-udev", options.no_udev, "As on a machine where no udev runs");
  program.require_subcommand(1);
  CLI::App* cycles = program.add_subcommand("cycles", "Unplug and plug in again");
  cycles->add_option("--count", options.cycles, "How often")->capture_default_str();
  CLI::App* throughput = program.add_subcommand("throughput", "Read at a rate, and account for every frame");
  throughput->add_option("--mb-per-s", options.mb_per_s, "The rate")->capture_default_str();
  CLI::App* random = program.add_subcommand("random", "Nothing but noise");
  for (CLI::App* command : {throughput, random}) {
    command->add_option("--seconds", options.seconds, "How long")->capture_default_str();
  }
  CLI11_PARSE(program, argc, argv);
  try {
    if (cycles->parsed()) run_cycles(options);
    if (throughput->parsed()) run_throughput(options);
    if (random->parsed()) run_random(options);
  } catch (const std::exception& failure) {
    std::fflush(stdout);
    fmt::print(stderr, "does not hold: {}\n", failure.what());
    return 1;
  }
  return 0;
}
