#pragma once

#include <umockdev.h>

#include <filesystem>
#include <mutex>
#include <string>

#include "tests/usb/g_ref.hpp"

namespace fanlight::test {

/// The USB bus of a machine that is not there: sysfs, /dev and the messages of udev as umockdev shows them to
/// this process and to those that it starts, if the library of umockdev is preloaded. Nothing of the real
/// machine's USB is to be seen meanwhile. At most one at a time in a process, since its folder travels in
/// the environment (UMOCKDEV_DIR): made before, and gone after, all use of libusb. Any thread.
class EmulatedBus {
 public:
  /// Whether arrivals and departures are told (by udev), or are only found by who looks anew.
  enum class Udev : bool { kOff, kOn };

  /// That the library is preloaded, without which there can be none.
  static bool preloaded();

  explicit EmulatedBus(Udev udev = Udev::kOn);

  /// A free port of the bus, for a device's whole life.
  unsigned new_port();

  struct Plugged {
    std::string sysfs_path;
    std::string node;  ///< "/dev/bus/usb/001/002"
  };
  /// A high speed device (usb_descriptors.hpp) comes to a port, under a device number that was not used
  /// lately; `handler` answers the ioctls of its node.
  Plugged plug(unsigned port, const std::string& serial, UMockdevIoctlBase* handler);
  void unplug(const Plugged& device);

 private:
  const Udev udev_;
  std::mutex mutex_;
  GRef<UMockdevTestbed> testbed_;
  std::filesystem::path root_;  // of what this process sees as /dev and /sys
  unsigned ports_ = 0;
  unsigned plugs_ = 0;
};

}  // namespace fanlight::test
