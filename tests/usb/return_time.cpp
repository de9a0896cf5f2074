// SPDX-License-Identifier: Apache-2.0
// Time without a current picture: from the unplug of the probe until the loss is known, and from the replug
// until the first picture of a new volume. The whole pipeline except the socket: emulated probe, libusb,
// ring, all passes.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <thread>
#include <vector>

#include "proto/base/clock.hpp"
#include "renderer/render_thread.hpp"
#include "tests/usb/acquisition_fixture.hpp"

namespace {

using namespace fanlight;
using namespace fanlight::test;

struct Options {
  int rounds = 10;
  bool no_udev = false;
  std::uint32_t side = 512;
  std::uint32_t picture = 512;
  double pause_s = 2;
};

template <typename T>
T value_of(Result<T> made) {
  if (!made) throw std::runtime_error(made.error().message);
  return *std::move(made);
}

/// The render thread and its dependencies, connected to an AcquisitionFixture.
class Rendering {
 public:
  Rendering(AcquisitionFixture& fixture, PictureSize size)
      : instance_(value_of(GpuInstance::create({}))),
        gpu_(value_of(Gpu::create(*instance_, ""))),
        link_(fixture.reader_bell(), bell_) {
    const SourceDescription& source = fixture.description();
    auto renderer = value_of(Renderer::create(
        {.size = size,
         .geometry = source.geometry,
         .first_angle_rad = source.first_angle_rad,
         .last_angle_rad = source.last_angle_rad,
         .frame_capacity = source.frames_per_volume,
         .usual_frames = source.usual_frames},
        {.gpu = *gpu_, .counters = counters_},
        {.revision = 1,
         .scene = scene_for(source.geometry, source.first_angle_rad, source.last_angle_rad, size.height)}));
    thread_ = std::make_unique<RenderThread>(
        DeviceRenderer{.renderer = std::move(renderer)},
        RenderThread::Dependencies{.ring = fixture.ring(), .link = link_, .counters = counters_});
  }

  /// Waits for a picture of a volume that began after this time.
  void wait_for_picture_after(std::int64_t time_ns) {
    for (;;) {
      const Picture* picture = link_.pictures.newest();
      if (picture != nullptr && picture->stamp.volume.first_capture_time_ns > time_ns) return;
      constexpr std::int64_t kMostNs = 60'000'000'000;
      if (picture == nullptr && !bell_.wait(kMostNs))
        throw std::runtime_error("no picture came for a minute");
    }
  }

 private:
  std::unique_ptr<GpuInstance> instance_;
  std::unique_ptr<Gpu> gpu_;
  RenderCounters counters_;
  Doorbell bell_;
  RenderLink link_;
  std::unique_ptr<RenderThread> thread_;
};

void print(const char* what, std::vector<double> times_ms) {
  std::ranges::sort(times_ms);
  fmt::print("{}: median {:.0f} ms, shortest {:.0f}, longest {:.0f}\n", what, times_ms[times_ms.size() / 2],
             times_ms.front(), times_ms.back());
}

void run(const Options& options) {
  AcquisitionFixture fixture({.model = {.frame_rate_hz = 75,
                                        .frames_per_volume = 35,
                                        .columns = options.side,
                                        .rows = options.side,
                                        .prepared = true},
                              .udev = options.no_udev ? EmulatedBus::Udev::kOff : EmulatedBus::Udev::kOn});
  Rendering rendering(fixture, {.width = options.picture, .height = options.picture});
  fixture.start();
  rendering.wait_for_picture_after(0);
  std::vector<double> lost_ms;
  std::vector<double> back_ms;
  for (int round = 0; round < options.rounds; ++round) {
    const std::uint64_t losses = fixture.counters().probes_lost.value();
    const std::int64_t unplugged_ns = now_ns();
    fixture.probe().unplug();
    if (!wait_until([&] { return fixture.counters().probes_lost.value() > losses; })) {
      throw std::runtime_error("the loss was not seen");
    }
    lost_ms.push_back(static_cast<double>(now_ns() - unplugged_ns) / 1e6);
    std::this_thread::sleep_for(std::chrono::duration<double>(options.pause_s));
    const std::int64_t plugged_ns = now_ns();
    fixture.probe().plug();
    rendering.wait_for_picture_after(plugged_ns);
    back_ms.push_back(static_cast<double>(now_ns() - plugged_ns) / 1e6);
  }
  fmt::print(
      "{} rounds {} udev, unplugged for {} s; 35 frames of {} x {} at 75 a second (467 ms a sweep), pictures "
      "of {} x {}\n",
      options.rounds, options.no_udev ? "without" : "with", options.pause_s, options.side, options.side,
      options.picture, options.picture);
  print("unplugged until the loss is known", lost_ms);
  print("plugged in until the first new picture", back_ms);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program(
      "From the probe's return to the first picture; to be started with umockdev's library preloaded");
  Options options;
  program.add_option("--rounds", options.rounds)->capture_default_str()->check(CLI::Range(1, 1000));
  program.add_flag("--no-udev", options.no_udev, "As on a machine where no udev runs");
  program
      .add_option("--pause-s", options.pause_s,
                  "For how long it is unplugged; a person needs a second or two")
      ->capture_default_str();
  program.add_option("--side", options.side, "Pixels of a frame, each way")->capture_default_str();
  program.add_option("--picture", options.picture, "Pixels of the picture, each way")->capture_default_str();
  CLI11_PARSE(program, argc, argv);
  try {
    run(options);
  } catch (const std::exception& failure) {
    std::fflush(stdout);
    fmt::print(stderr, "does not hold: {}\n", failure.what());
    return 1;
  }
  return 0;
}
