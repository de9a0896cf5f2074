// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>

#include "tests/usb/emulated_bus.hpp"
#include "tests/usb/probe_core.hpp"
#include "tests/usb/usbfs_device.hpp"

namespace fanlight::test {

/// A probe on an EmulatedBus: ProbeModel behind the node that libusb opens, with the faults of a FaultScript
/// and injected ones.
///
/// Life: created unplugged -> plug() -> unplug() -> plug() -> ... The destructor unplugs; it must not outlive
/// its bus. All functions may be called from any thread. They take effect before they return, except unplug
/// and replug of inject(), which follow soon after. Needs CPU time of its own: umockdev's thread answers the
/// ioctls.
class UsbfsProbe {
 public:
  struct Config {
    ProbeModel::Config model;
    std::string faults;  ///< FaultScript, started by the first plug
  };
  /// kInvalidArgument where a value is out of its range or the script is not valid.
  static Result<std::unique_ptr<UsbfsProbe>> create(EmulatedBus& bus, const Config& config);
  ~UsbfsProbe();
  UsbfsProbe(const UsbfsProbe&) = delete;
  UsbfsProbe& operator=(const UsbfsProbe&) = delete;

  /// No effect where it is plugged in.
  void plug();
  /// With all pending transfers; no effect where it is not plugged in.
  void unplug();
  bool plugged();

  void inject(const Fault& fault);

  ProbeModel::Counters counters();
  std::uint64_t waiting();  ///< ProbeModel::waiting()
  bool streaming();
  std::uint64_t carried_out(FaultKind kind);

 private:
  UsbfsProbe(EmulatedBus& bus, std::shared_ptr<ProbeCore> core);

  void plug_locked();
  void unplug_locked();
  void follow_script(std::stop_token stop);
  void fulfil_plug_wish();

  EmulatedBus& bus_;
  const std::shared_ptr<ProbeCore> core_;
  const unsigned port_;
  bool script_began_ = false;
  // of the present plug
  std::shared_ptr<UsbfsDevice> device_;
  EmulatedBus::Plugged place_;
  std::jthread follower_;  // last member: it ends first
};

}  // namespace fanlight::test
