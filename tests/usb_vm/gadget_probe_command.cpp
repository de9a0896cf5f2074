// SPDX-License-Identifier: Apache-2.0
// A probe on this machine's own USB device controller, controlled by standard input. Each line is a fault in
// the words of fault_script.hpp ("noise 1000", "unplug"; "replug" also plugs in an unplugged probe) or
// "counters". Each is answered by one line: the time in ns on the monotonic clock (for plug and unplug the
// time of the kernel call), the model's counters, or "?".

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <string>

#include "proto/base/clock.hpp"
#include "tests/usb_vm/gadget_probe.hpp"

namespace fanlight::test {
namespace {

void add_options(CLI::App& program, GadgetProbe::Config& probe) {
  ProbeModel::Config& model = probe.model;
  program.add_option("--rate", model.frame_rate_hz, "Frames a second")->capture_default_str();
  program.add_option("--frames", model.frames_per_volume, "Frames per volume")->capture_default_str();
  program.add_option("--columns", model.columns)->capture_default_str();
  program.add_option("--rows", model.rows, "At the full depth of 160 mm")->capture_default_str();
  program.add_option("--room", model.room_frames, "Frames kept while no one takes them; 0: those of 50 ms")
      ->capture_default_str();
  program.add_option("--faults", probe.faults, "When which fault happens, see fault_script.hpp");
  program.add_option("--serial", model.serial)->capture_default_str();
}

std::string text(const ProbeModel::Counters& count) {
  return fmt::format("taken {} sent {} dropped {} withheld {} torn {} starts {} bytes {}", count.frames_taken,
                     count.frames_sent, count.frames_dropped, count.frames_withheld, count.frames_torn,
                     count.starts, count.bytes);
}

std::int64_t carry_out(GadgetProbe& probe, const Fault& fault) {
  switch (fault.kind) {
    case FaultKind::kUnplug:
      return probe.unplug();
    case FaultKind::kReplug:
      probe.unplug();
      return probe.plug();
    default:
      probe.inject(fault);
      return now_ns();
  }
}

std::string follow(GadgetProbe& probe, const std::string& line) {
  if (line == "counters") return text(probe.counters());
  auto script = FaultScript::parse("at 0s " + line);
  if (!script) return "?";
  script->begin(0);
  std::int64_t done_ns = now_ns();
  for (const Fault& fault : script->due(0)) done_ns = carry_out(probe, fault);
  return fmt::format("{}", done_ns);
}

}  // namespace
}  // namespace fanlight::test

int main(int argc, char** argv) {
  using namespace fanlight::test;
  GadgetProbe::Config config{.model = {.prepared = true}};
  CLI::App program("A USB probe, 1209:0001, on this machine's own device controller", "gadget_probe");
  add_options(program, config);
  CLI11_PARSE(program, argc, argv);
  const auto probe = GadgetProbe::create(config);
  if (!probe) {
    fmt::print(stderr, "gadget_probe: {}\n", probe.error().message);
    return 1;
  }
  const std::int64_t plugged_ns = (*probe)->plug();
  if (plugged_ns == 0) {
    fmt::print(stderr,
               "gadget_probe: the kernel did not plug it in, expected a device controller that is free\n");
    return 1;
  }
  fmt::print("{}\n", plugged_ns);
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    fmt::print("{}\n", follow(**probe, line));
    std::fflush(stdout);
  }
  return 0;
}
