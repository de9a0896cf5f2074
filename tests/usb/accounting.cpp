// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/accounting.hpp"

#include <fmt/format.h>

namespace fanlight::test {

namespace {

/// "drop 3, cut 1", or with quotes and colons.
std::string faults_of(UsbfsProbe& probe, std::string_view form) {
  std::string list;
  for (const FaultWord& fault : fault_words()) {
    const std::uint64_t times = probe.carried_out(fault.kind);
    if (times == 0) continue;
    list += fmt::format("{}{}", list.empty() ? "" : ", ", fmt::format(fmt::runtime(form), fault.word, times));
  }
  return list;
}

}  // namespace

std::string accounting_line(const std::string& serial, UsbfsProbe& probe) {
  const ProbeModel::Counters count = probe.counters();
  const std::string faults = faults_of(probe, "{} {}");
  return fmt::format(
      "probe {}: {} frames taken = {} sent + {} dropped + {} withheld + {} torn + {} waiting; {} bytes, {} "
      "starts; faults: {}",
      serial, count.frames_taken, count.frames_sent, count.frames_dropped, count.frames_withheld,
      count.frames_torn, probe.waiting(), count.bytes, count.starts, faults.empty() ? "none" : faults);
}

std::string accounting_json(const std::string& serial, UsbfsProbe& probe) {
  const ProbeModel::Counters count = probe.counters();
  const std::pair<std::string_view, std::uint64_t> values[] = {{"frames_taken", count.frames_taken},
                                                               {"frames_sent", count.frames_sent},
                                                               {"frames_dropped", count.frames_dropped},
                                                               {"frames_withheld", count.frames_withheld},
                                                               {"frames_torn", count.frames_torn},
                                                               {"waiting", probe.waiting()},
                                                               {"repeats", count.repeats},
                                                               {"swaps", count.swaps},
                                                               {"damaged", count.damaged},
                                                               {"damaged_headers", count.damaged_headers},
                                                               {"invalid", count.invalid},
                                                               {"noise_bytes", count.noise_bytes},
                                                               {"bytes", count.bytes},
                                                               {"starts", count.starts}};
  std::string object = fmt::format("{{\"serial\": \"{}\"", serial);
  for (const auto& [name, value] : values) object += fmt::format(", \"{}\": {}", name, value);
  return object + fmt::format(", \"faults\": {{{}}}}}", faults_of(probe, "\"{}\": {}"));
}

}  // namespace fanlight::test
