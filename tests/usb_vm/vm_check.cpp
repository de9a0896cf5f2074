// SPDX-License-Identifier: Apache-2.0
// Fanlight's own reader with a probe on the kernel's own USB stack; see tests/README.md, "usb-vm".
//   vm_check GADGET_PROBE

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "proto/base/clock.hpp"
#include "tests/usb/resources.hpp"
#include "tests/usb_vm/check_list.hpp"
#include "tests/usb_vm/gadget_process.hpp"
#include "tests/usb_vm/reader_fixture.hpp"

namespace fanlight::test {
namespace {

constexpr int kCycles = 10;
constexpr int kWarmUpCycles = 3;  // these fill caches and pools of libusb and the allocator

/// 128 x 128 pixels, 10 frames a volume: a sweep takes 50 ms. The buffers cover delays of a busy machine.
const std::vector<std::string> kSmallProbe = {"--columns", "128",    "--rows", "128",    "--frames",
                                              "10",        "--rate", "200",    "--room", "400"};
/// 64 x 31 pixels and the header are two whole packets: each frame ends with an empty one.
const std::vector<std::string> kEvenProbe = {"--columns", "64",     "--rows", "31",     "--frames",
                                             "10",        "--rate", "200",    "--room", "400"};
/// More than any bus can carry here.
const std::vector<std::string> kFastProbe = {"--columns", "512", "--rows", "512",
                                             "--frames",  "8",   "--rate", "1000"};

void sleep_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

std::string frames_text(const ReaderFixture& fixture) {
  const AcquisitionCounters& frames = fixture.frames();
  return fmt::format("{} received, {} missing, {} cut, {} damaged, {} reordered, {} bytes skipped",
                     frames.frames_received.value(), frames.frames_missing.value(), frames.frames_cut.value(),
                     frames.frames_damaged.value(), frames.frames_reordered.value(),
                     fixture.counters().bytes_skipped.value());
}

bool nothing_broken(const ReaderFixture& fixture) {
  const AcquisitionCounters& frames = fixture.frames();
  return frames.frames_cut.value() + frames.frames_damaged.value() + frames.frames_reordered.value() +
             frames.frames_repeated.value() + frames.frames_misfit.value() +
             fixture.counters().bytes_skipped.value() ==
         0;
}

/// Frame rate with a probe that is faster than the bus. The probe drops frames, so that hardly any sweep is
/// complete.
std::string check_rate(ReaderFixture& fixture) {
  constexpr double kSeconds = 5;
  await([&] { return fixture.frames().frames_received.value() > 0; }, "no frame came");
  const std::int64_t start_ns = now_ns();
  const std::uint64_t start_bytes = fixture.counters().bytes_received.value();
  sleep_s(kSeconds);
  const double mb = static_cast<double>(fixture.counters().bytes_received.value() - start_bytes) / 1e6;
  const double seconds = static_cast<double>(now_ns() - start_ns) / 1e9;
  require(nothing_broken(fixture), frames_text(fixture));
  require(fixture.frames().sum_holds(), "frames are not accounted for");
  return fmt::format("{:.1f} MB/s for {:.1f} s; frames {}", mb / seconds, seconds, frames_text(fixture));
}

/// Every frame whole and in order, and every volume complete.
std::string check_order(ReaderFixture& fixture, int most_volumes) {
  std::optional<VolumeStamp> last;
  int volumes = 0;
  while (volumes < most_volumes) {
    fixture.next_volume([&](const Volume& volume) {
      const VolumeStamp& stamp = volume.stamp();
      require(stamp.frames == 10 && stamp.frames_missing == 0 &&
                  stamp.last_frame_sequence - stamp.first_frame_sequence == 9,
              "a volume is not whole");
      require(!last || stamp.source_volume_index > last->source_volume_index, "a volume came late");
      last = stamp;
      return true;
    });
    ++volumes;
  }
  require(nothing_broken(fixture) && fixture.frames().frames_missing.value() == 0, frames_text(fixture));
  return fmt::format("{} volumes; frames {}", volumes, frames_text(fixture));
}

double median(std::vector<double>& values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

struct CycleTimes {
  std::vector<double> noticed_ms;
  std::vector<double> back_ms;
};

/// Unplugs with pending reads, and plugs in again.
void run_cycle(GadgetProcess& gadget, ReaderFixture& fixture, CycleTimes& times) {
  fixture.next_volume();
  const std::uint64_t lost = fixture.counters().probes_lost.value();
  const std::int64_t unplugged_ns = gadget.inject("unplug");
  await([&] { return fixture.counters().probes_lost.value() > lost; }, "the loss was not seen");
  times.noticed_ms.push_back(static_cast<double>(now_ns() - unplugged_ns) / 1e6);
  require(fixture.frames().sum_holds(), "frames are not accounted for after an unplug");
  const std::int64_t plugged_ns = gadget.inject("replug");
  fixture.next_volume();
  times.back_ms.push_back(static_cast<double>(now_ns() - plugged_ns) / 1e6);
}

void check_cycles(CheckList& checks, GadgetProcess& gadget, ReaderFixture& fixture) {
  CycleTimes times;
  Resources before;
  checks.run(fmt::format("{} times unplugged with reads under way, and back", kCycles), [&] {
    for (int cycle = 0; cycle < kWarmUpCycles; ++cycle) run_cycle(gadget, fixture, times);
    times = {};
    before = Resources::now();
    const ProbeCounters& counters = fixture.counters();
    const std::uint64_t failed = counters.transfers_failed.value();
    for (int cycle = 0; cycle < kCycles; ++cycle) run_cycle(gadget, fixture, times);
    return fmt::format("{} of the losses began as a transfer error",
                       counters.transfers_failed.value() - failed);
  });
  if (times.back_ms.empty()) return;
  checks.run("unplug noticed", [&] {
    const double middle = median(times.noticed_ms);
    return fmt::format("after {:.1f} ms (median of {}, longest {:.1f} ms)", middle, times.noticed_ms.size(),
                       times.noticed_ms.back());
  });
  checks.run("first volume after the replug, without udev", [&] {
    const double middle = median(times.back_ms);
    return fmt::format("after {:.0f} ms, 50 ms of them its sweep (median of {}, longest {:.0f} ms)", middle,
                       times.back_ms.size(), times.back_ms.back());
  });
  checks.run("nothing left behind", [&] {
    const Resources after = Resources::now();
    require(after.files == before.files && after.threads == before.threads,
            fmt::format("{} files and {} threads before, {} and {} after", before.files, before.threads,
                        after.files, after.threads));
    return fmt::format("{} files and {} threads before and after", after.files, after.threads);
  });
}

struct FaultCheck {
  std::string fault;
  const Counter* counter;
  std::string counts;
};

std::vector<FaultCheck> fault_checks(const ReaderFixture& fixture) {
  const AcquisitionCounters& frames = fixture.frames();
  const ProbeCounters& probe = fixture.counters();
  return {{"drop", &frames.frames_missing, "frames missing"},
          {"invalid", &frames.frames_invalid, "frames invalid"},
          {"damage", &frames.frames_damaged, "frames damaged"},
          {"damage-header", &frames.frames_missing, "frames missing"},
          {"cut", &frames.frames_cut, "frames cut"},
          {"repeat", &frames.frames_repeated, "frames repeated"},
          {"swap", &frames.frames_reordered, "frames reordered"},
          {"noise 1000", &probe.bytes_skipped, "bytes skipped"},
          {"geometry", &frames.geometry_changes, "geometry changes"},
          {"geometry", &frames.geometry_changes, "geometry changes"},
          {"restart", &frames.sequence_restarts, "sequence restarts"},
          {"stall", &probe.transfers_stalled, "stalls"},
          {"silent 2s", &probe.streams_restarted, "streams restarted"},
          {"random", &probe.streams_restarted, "streams restarted"},
          // Longer than three repairs of the stream: the reader resets the device and opens it again.
          {"silent 8s", &probe.probes_lost, "losses"}};
}

std::string check_fault(GadgetProcess& gadget, ReaderFixture& fixture, const FaultCheck& check) {
  fixture.next_volume();
  const std::uint64_t before = check.counter->value();
  const std::int64_t start_ns = gadget.inject(check.fault);
  await([&] { return check.counter->value() > before; }, "it was not counted under " + check.counts);
  const std::uint64_t counted = check.counter->value() - before;
  const double ms = static_cast<double>(now_ns() - start_ns) / 1e6;
  fixture.next_volume();
  require(fixture.frames().sum_holds(), "frames are not accounted for");
  return fmt::format("{} +{} after {:.0f} ms, the next volume after {:.0f} ms", check.counts, counted, ms,
                     static_cast<double>(now_ns() - start_ns) / 1e6);
}

/// A probe that answers no request while an order arrives.
std::string check_mute(GadgetProcess& gadget, ReaderFixture& fixture) {
  const probe::Settings settings = fixture.status().settings;
  gadget.inject("mute 700ms");
  const std::string refusal =
      fixture.order({settings.sweep_deg - 1, settings.frames_a_volume, settings.depth_mm});
  require(!refusal.empty(), "the order was not refused");
  fixture.next_volume();
  const std::string again = fixture.order(settings);
  require(again.empty(), again);
  fixture.next_volume();
  return fmt::format("\"{}\"; the next order was taken", refusal);
}

/// A probe that does not identify itself at first after its return.
std::string check_late_identity(GadgetProcess& gadget, ReaderFixture& fixture) {
  const std::uint64_t lost = fixture.counters().probes_lost.value();
  const std::uint64_t failed = fixture.counters().requests_failed.value();
  gadget.inject("unplug");
  await([&] { return fixture.counters().probes_lost.value() > lost; }, "the loss was not seen");
  gadget.inject("late-identity");
  const std::int64_t plugged_ns = gadget.inject("replug");
  fixture.next_volume();
  require(fixture.counters().requests_failed.value() > failed, "no request went unanswered");
  return fmt::format("the first volume {:.0f} ms after the replug",
                     static_cast<double>(now_ns() - plugged_ns) / 1e6);
}

std::string check_settings(ReaderFixture& fixture) {
  const probe::Settings before = fixture.status().settings;
  const probe::Settings wanted{.sweep_deg = 50, .frames_a_volume = 14, .depth_mm = 100};
  const std::string refusal = fixture.order(wanted);
  require(refusal.empty(), refusal);
  const std::int64_t start_ns = now_ns();
  double swept_deg = 0;
  fixture.next_volume([&](const Volume& volume) {
    const auto angles = volume.angles_rad();
    swept_deg = angles.empty() ? 0 : degrees(std::ranges::max(angles) - std::ranges::min(angles));
    return volume.stamp().frames == 14 && volume.geometry().rows == 80;
  });
  const double ms = static_cast<double>(now_ns() - start_ns) / 1e6;
  require(swept_deg > 49 && swept_deg < 51, fmt::format("the sweep is {:.1f} deg", swept_deg));
  const std::string too_much = fixture.order({.sweep_deg = 500, .frames_a_volume = 14, .depth_mm = 100});
  require(!too_much.empty(), "a sweep of 500 deg was taken");
  const std::string back = fixture.order(before);
  require(back.empty(), back);
  fixture.next_volume([](const Volume& volume) { return volume.geometry().rows == 128; });
  return fmt::format("14 frames of 128 x 80 over {:.1f} deg after {:.0f} ms, and back", swept_deg, ms);
}

void check_fast_probe(CheckList& checks, const std::string& program) {
  const GadgetProcess gadget(program, kFastProbe);
  ReaderFixture fixture;
  checks.run("rate", [&] { return check_rate(fixture); });
}

void check_even_probe(CheckList& checks, const std::string& program) {
  const GadgetProcess gadget(program, kEvenProbe);
  ReaderFixture fixture;
  checks.run("whole and in order", [&] { return check_order(fixture, 40); });
}

void check_small_probe(CheckList& checks, const std::string& program) {
  GadgetProcess gadget(program, kSmallProbe);
  ReaderFixture fixture;
  checks.run("whole and in order", [&] { return check_order(fixture, 100); });
  check_cycles(checks, gadget, fixture);
  for (const FaultCheck& check : fault_checks(fixture))
    checks.run(check.fault, [&] { return check_fault(gadget, fixture, check); });
  checks.run("mute 700ms", [&] { return check_mute(gadget, fixture); });
  checks.run("late-identity", [&] { return check_late_identity(gadget, fixture); });
  checks.run("settings in mid-stream", [&] { return check_settings(fixture); });
  fixture.stop();
  checks.run("accounting at the end", [&] {
    require(fixture.frames().sum_holds(), "frames are not accounted for");
    return fmt::format("of {} frames received {} are in volumes, and each of the others has its name",
                       fixture.frames().frames_received.value(), fixture.frames().frames_assembled.value());
  });
  fmt::print("       the probe's: {}", gadget.ask("counters"));
}

}  // namespace
}  // namespace fanlight::test

int main(int argc, char** argv) {
  using namespace fanlight::test;
  if (argc != 2) {
    fmt::print(stderr, "vm_check: expected the path of gadget_probe\n");
    return 2;
  }
  CheckList checks;
  const std::string program = argv[1];
  checks.section("512 x 512 pixels, as fast as they go", [&] { check_fast_probe(checks, program); });
  checks.section("64 x 31 pixels, each frame ended by an empty packet",
                 [&] { check_even_probe(checks, program); });
  checks.section("128 x 128 pixels, 200 frames a second, 10 a volume",
                 [&] { check_small_probe(checks, program); });
  return checks.all_passed() ? 0 : 1;
}
