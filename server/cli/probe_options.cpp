// SPDX-License-Identifier: Apache-2.0
#include "server/cli/probe_options.hpp"

#include <fmt/format.h>

#include "proto/base/printable.hpp"

namespace fanlight {

void add_probe_options(CLI::App& command, SourceOptions& options) {
  UsbSource::Settings& settings = options.probe_settings;
  command
      .add_option("--probe.sweep_deg", settings.sweep_deg,
                  "Angle from the first frame of a sweep to the last")
      ->type_name("DEG")
      ->group("USB probe");
  command.add_option("--probe.frames", settings.frames_a_volume, "Frames per volume")
      ->type_name("N")
      ->group("USB probe");
  command.add_option("--probe.depth_mm", settings.depth_mm, "Depth below the probe face")
      ->type_name("MM")
      ->group("USB probe");
  command
      .add_option("--probe.wait_s", options.wait_for_probe_s, "How long to wait until a probe is connected")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("S")
      ->group("USB probe");
}

std::string opening_note(const std::string& source, const SourceOptions& options) {
  if (source.starts_with("igtl:"))
    return fmt::format("connecting to {} and looking at its first sweeps, which takes some seconds",
                       printable(source));
  if (source.starts_with("usb:") && options.wait_for_probe_s > 0)
    return fmt::format("waiting for {}, at most {} s", printable(source), options.wait_for_probe_s);
  return {};
}

}  // namespace fanlight
