#pragma once

#include <libusb.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "acquisition/usb_address.hpp"

namespace fanlight {

/// The USB buses of this machine, watched for devices with one vendor and product. One thread.
///
/// A libusb context hears of arrivals only where udev runs. Where it does not, a context never sees a device
/// that came after it was made; a new one does. Whoever waits for a device therefore makes a new UsbBus
/// every so often.
class UsbBus {
 public:
  /// kUnavailable where libusb cannot work here (no /dev/bus/usb, no memory).
  static Result<std::unique_ptr<UsbBus>> create(const UsbAddress& address);
  ~UsbBus();
  UsbBus(const UsbBus&) = delete;
  UsbBus& operator=(const UsbBus&) = delete;

  libusb_context* context() const { return context_; }

  /// Runs the callbacks of what happened on the bus, waiting up to timeout_us for something to happen.
  void handle_events(std::int64_t timeout_us) const;

  /// A device that is there and was not given out before; the caller unrefs it. nullptr: none.
  libusb_device* next_arrival();

 private:
  UsbBus() = default;
  static int LIBUSB_CALL arrived(libusb_context* context, libusb_device* device, libusb_hotplug_event event,
                                 void* self);

  libusb_context* context_ = nullptr;
  std::vector<libusb_device*> arrivals_;  // referenced
};

}  // namespace fanlight
