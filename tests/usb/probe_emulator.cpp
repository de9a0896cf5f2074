// SPDX-License-Identifier: Apache-2.0
// Runs a command with an emulated probe; see README.md.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/usb/accounting.hpp"
#include "tests/usb/child_process.hpp"
#include "tests/usb/usbfs_probe.hpp"

namespace fanlight::test {
namespace {

constexpr int kUsageError = 2;
constexpr double kBytesInMb = 1e6;

struct Options {
  UsbfsProbe::Config probe;
  std::vector<std::string> serials = {"0001"};
  double mb_per_s = 0;
  bool no_udev = false;
  bool no_volume_index = false;
  bool no_transfer_ends = false;
  std::optional<double> seconds;
  std::string json_path;
  std::vector<std::string> command;
};

void add_options(CLI::App& program, Options& options) {
  ProbeModel::Config& model = options.probe.model;
  program.add_option("--rate", model.frame_rate_hz, "Frames a second")->capture_default_str();
  program.add_option("--frames", model.frames_per_volume, "Frames per volume")->capture_default_str();
  program.add_option("--columns", model.columns)->capture_default_str();
  program.add_option("--rows", model.rows, "At the full depth of 160 mm")->capture_default_str();
  program.add_option("--sweep", model.sweep_deg, "Degrees from a sweep's first frame to its last")
      ->capture_default_str();
  program.add_option("--depth", model.depth_mm, "Millimetres")->capture_default_str();
  program.add_option("--lag", model.lag_deg, "Degrees by which forward and backward disagree")
      ->capture_default_str();
  program.add_option("--room", model.room_frames, "Frames kept while no one takes them; 0: those of 50 ms")
      ->capture_default_str();
  program.add_option("--mb-per-s", options.mb_per_s,
                     "As many frames as that needs, in place of --rate; their pictures are drawn before");
  program.add_flag("--no-udev", options.no_udev, "Arrivals and departures are not told");
  program.add_flag("--no-volume-index", options.no_volume_index, "Frames do not name their sweep");
  program.add_flag("--no-transfer-ends", options.no_transfer_ends, "Frames do not end their transfers");
  program.add_option("--faults", options.probe.faults, "When which fault happens, see fault_script.hpp");
  program.add_option("--serial", options.serials, "Serial number; more than one: as many probes")
      ->capture_default_str();
  program.add_option("--seconds", options.seconds, "Ends the command after that time");
  program.add_option("--json", options.json_path, "File for the accounting");
  program.add_option("command", options.command, "After --: a command and its arguments")->required();
}

void settle(Options& options) {
  ProbeModel::Config& model = options.probe.model;
  model.counts_volumes = !options.no_volume_index;
  model.ends_transfers = !options.no_transfer_ends;
  if (options.mb_per_s <= 0) return;
  model.prepared = true;
  model.frame_rate_hz =
      options.mb_per_s * kBytesInMb / (probe::kFrameHeaderBytes + double{1} * model.columns * model.rows);
}

/// Executes this program again with umockdev's library preloaded, which is possible only at the start of a
/// process. Returns only on failure.
void preload_and_restart(char** arguments) {
  const char* const before = std::getenv("LD_PRELOAD");
  const std::string others = before != nullptr ? before : "";
  if (others.find("umockdev") != std::string::npos) return;
  setenv("LD_PRELOAD", (FANLIGHT_PRELOADED + (others.empty() ? "" : ":" + others)).c_str(), 1);
  execv("/proc/self/exe", arguments);
}

using Probes = std::vector<std::unique_ptr<UsbfsProbe>>;

Result<Probes> plugged_in(EmulatedBus& bus, const Options& options) {
  Probes probes;
  for (const std::string& serial : options.serials) {
    UsbfsProbe::Config config = options.probe;
    config.model.serial = serial;
    auto probe = UsbfsProbe::create(bus, config);
    if (!probe) return probe.error();
    probes.push_back(std::move(*probe));
  }
  for (const auto& probe : probes) probe->plug();
  return probes;
}

void account(const Options& options, const Probes& probes) {
  std::string json;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    fmt::print(stderr, "{}\n", accounting_line(options.serials[i], *probes[i]));
    json += fmt::format("{}{}", json.empty() ? "[" : ",\n ", accounting_json(options.serials[i], *probes[i]));
  }
  if (!options.json_path.empty()) std::ofstream(options.json_path) << json << "]\n";
}

Result<int> run(const Options& options) {
  ChildProcess::keep_signals();
  EmulatedBus bus(options.no_udev ? EmulatedBus::Udev::kOff : EmulatedBus::Udev::kOn);
  const auto probes = plugged_in(bus, options);
  if (!probes) return probes.error();
  auto child = ChildProcess::start(options.command);
  if (!child) return child.error();
  const int status = child->wait(options.seconds);
  account(options, *probes);
  return status;
}

}  // namespace
}  // namespace fanlight::test

int main(int argc, char** argv) {
  using namespace fanlight::test;
  Options options;
  CLI::App program("Runs a command on a machine with an emulated USB probe, 1209:0001.", "probe_emulator");
  add_options(program, options);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : kUsageError;
  }
  settle(options);
  if (!EmulatedBus::preloaded()) {
    preload_and_restart(argv);
    std::fprintf(stderr, "probe_emulator: the library of umockdev cannot be preloaded, expected %s\n",
                 FANLIGHT_PRELOADED);
    return 1;
  }
  const auto status = run(options);
  if (status) return *status;
  std::fprintf(stderr, "probe_emulator: %s\n", status.error().message.c_str());
  return status.error().code == fanlight::ErrorCode::kInvalidArgument ? kUsageError : 1;
}
