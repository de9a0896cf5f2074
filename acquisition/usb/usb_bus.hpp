// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libusb.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "acquisition/usb/usb_address.hpp"

namespace fanlight {

/// USB buses of this machine, watched for devices with one vendor and product. One thread.
///
/// A libusb context is notified of new devices only where udev runs. Elsewhere a context never sees a device
/// that was plugged in after the context was created, but a new context does. A caller that waits for a
/// device must therefore create a new UsbBus from time to time.
class UsbBus {
 public:
  /// kUnavailable where libusb cannot work (no /dev/bus/usb, no memory).
  static Result<std::unique_ptr<UsbBus>> create(const UsbAddress& address);
  ~UsbBus();
  UsbBus(const UsbBus&) = delete;
  UsbBus& operator=(const UsbBus&) = delete;

  libusb_context* context() const { return context_; }

  /// Runs the callbacks of bus events; waits up to timeout_us for one.
  void handle_events(std::int64_t timeout_us) const;

  /// A device that is plugged in and was not returned before; the caller must unreference it. nullptr: none.
  libusb_device* next_arrival();

 private:
  UsbBus() = default;
  static int LIBUSB_CALL arrived(libusb_context* context, libusb_device* device, libusb_hotplug_event event,
                                 void* self);

  libusb_context* context_ = nullptr;
  std::vector<libusb_device*> arrived_devices_;  // referenced
};

}  // namespace fanlight
