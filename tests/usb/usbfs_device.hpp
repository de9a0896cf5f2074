// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <umockdev.h>

#include <cstdint>
#include <list>
#include <memory>

#include "tests/usb/probe_core.hpp"
#include "tests/usb/usbfs_client.hpp"

namespace fanlight::test {

/// The device node of one plug: answers like the kernel's usbfs from the plug to the unplug, and with ENODEV
/// as long as a client keeps the node open after that.
///
/// Ioctls arrive on umockdev's own thread; gone() and wake() may be called on any. Lives as long as the
/// object of handler(), or a client.
class UsbfsDevice : public std::enable_shared_from_this<UsbfsDevice> {
 public:
  explicit UsbfsDevice(std::shared_ptr<ProbeCore> core) : core_(std::move(core)) {}

  /// For umockdev_testbed_attach_ioctl().
  GRef<UMockdevIoctlBase> handler();

  /// Unplugged: the first pending bulk transfer ends with EPROTO and all others with ESHUTDOWN, as on a real
  /// bus, where the device becomes silent before the hub reports it. The caller must hold core's mutex.
  void gone();

  /// Transfers may have become completable. The caller must hold core's mutex.
  void wake();

 private:
  static gboolean on_ioctl(UMockdevIoctlBase* base, UMockdevIoctlClient* client, gpointer self);
  static void on_connected(UMockdevIoctlBase* base, UMockdevIoctlClient* client, gpointer self);

  void forget_closed();
  void start_ticking();
  void tick();
  void arm_tick();

  int perform(UsbfsClient& client, unsigned long request, UMockdevIoctlData* argument);
  int claim(UsbfsClient& client, std::optional<std::uint32_t> interface);
  int submit(UsbfsClient& client, UMockdevIoctlData* argument);
  void control(UsbfsClient& client, Urb& urb);
  bool waits_for_data(const UsbfsClient& client) const;
  void pump();
  bool fill(Urb& urb);
  void fail(Urb& urb, FaultKind fault);

  const std::shared_ptr<ProbeCore> core_;
  std::list<UsbfsClient> clients_;
  bool gone_ = false;
  GSource* tick_ = nullptr;  // on the ioctl thread
};

}  // namespace fanlight::test
