// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tests/usb/usbfs_probe.hpp"

namespace fanlight::test {

/// One line for a user: how many frames of a probe were sent, dropped and so on, and which faults were
/// executed.
std::string accounting_line(const std::string& serial, UsbfsProbe& probe);
/// The same as a JSON object, with the members of ProbeModel::Counters as keys; "faults" has the words of
/// FaultScript.
std::string accounting_json(const std::string& serial, UsbfsProbe& probe);

}  // namespace fanlight::test
