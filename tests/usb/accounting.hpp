#pragma once

#include <string>

#include "tests/usb/usbfs_probe.hpp"

namespace fanlight::test {

/// Where every frame of a probe went, and which faults were carried out, as one line for a person.
std::string accounting_line(const std::string& serial, UsbfsProbe& probe);
/// The same as a JSON object, keyed as the members of ProbeModel::Counters; "faults" has the words of
/// FaultScript.
std::string accounting_json(const std::string& serial, UsbfsProbe& probe);

}  // namespace fanlight::test
