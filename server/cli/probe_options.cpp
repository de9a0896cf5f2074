// SPDX-License-Identifier: Apache-2.0
#include "server/cli/probe_options.hpp"

#include <fmt/format.h>

#include "proto/base/printable.hpp"

namespace fanlight {

void add_probe_options(CLI::App& command, SourceOptions& options) {
  UsbSource::Settings& settings = options.probe_settings;
  command
      .add_option("--probe.sweep_deg", settings.sweep_deg,
                  "Of a USB probe: from a sweep's first frame to its last")
      ->type_name("DEG")
      ->group("USB probe");
  command.add_option("--probe.frames", settings.frames_a_volume, "Frames a volume")
      ->type_name("N")
      ->group("USB probe");
  command.add_option("--probe.depth_mm", settings.depth_mm, "Depth below the probe face")
      ->type_name("MM")
      ->group("USB probe");
  command
      .add_option("--probe.wait_s", options.wait_for_probe_s,
                  "How long to wait for a probe that is not plugged in")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e9))
      ->type_name("S")
      ->group("USB probe");
}

std::string opening_note(const std::string& source, const SourceOptions& options) {
  if (source.starts_with("igtl:"))
    return fmt::format("connects to {} and looks at its first sweeps, which takes some seconds",
                       printable(source));
  if (source.starts_with("usb:") && options.wait_for_probe_s > 0)
    return fmt::format("waits for {}, {} s at most", printable(source), options.wait_for_probe_s);
  return {};
}

}  // namespace fanlight
