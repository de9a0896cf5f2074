// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <umockdev.h>

#include <filesystem>
#include <mutex>
#include <string>

#include "tests/usb/g_ref.hpp"

namespace fanlight::test {

/// An emulated USB bus: sysfs, /dev and udev messages from umockdev, for this process and its children, if
/// umockdev's library is preloaded. The real machine's USB is hidden meanwhile. At most one in a process,
/// because its folder is passed in the environment (UMOCKDEV_DIR): it must exist before, and be destroyed
/// after, all use of libusb. Any thread.
class EmulatedBus {
 public:
  /// Whether udev messages announce plugging; otherwise only a new enumeration finds devices.
  enum class Udev : bool { kOff, kOn };

  /// Whether umockdev's library is preloaded; required.
  static bool preloaded();

  explicit EmulatedBus(Udev udev = Udev::kOn);

  /// A free port of the bus, reserved for a device.
  unsigned new_port();

  struct Plugged {
    std::string sysfs_path;
    std::string node;  ///< "/dev/bus/usb/001/002"
  };
  /// Plugs a high speed device (usb_descriptors.hpp) into a port, under a device number that was not used
  /// recently; `handler` answers the ioctls of its node.
  Plugged plug(unsigned port, const std::string& serial, UMockdevIoctlBase* handler);
  void unplug(const Plugged& device);

 private:
  const Udev udev_;
  std::mutex mutex_;
  GRef<UMockdevTestbed> testbed_;
  std::filesystem::path root_;  // root of this process's /dev and /sys
  unsigned ports_ = 0;
  unsigned plugs_ = 0;
};

}  // namespace fanlight::test
