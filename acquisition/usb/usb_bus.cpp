// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/usb_bus.hpp"

#include <fmt/format.h>

#include "proto/exchange/pulse.hpp"

namespace fanlight {

Result<std::unique_ptr<UsbBus>> UsbBus::create(const UsbAddress& address) {
  std::unique_ptr<UsbBus> made(new UsbBus);
  int failure = libusb_init(&made->context_);
  if (failure == LIBUSB_SUCCESS) {
    // Also reports each device that is already plugged in, during this call.
    failure = libusb_hotplug_register_callback(
        made->context_, LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED, LIBUSB_HOTPLUG_ENUMERATE, address.vendor,
        address.product, LIBUSB_HOTPLUG_MATCH_ANY, &UsbBus::arrived, made.get(), nullptr);
  }
  if (failure != LIBUSB_SUCCESS) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("the USB buses could not be read ({}), expected a kernel with "
                             "USB and a readable /dev/bus/usb",
                             libusb_strerror(failure))};
  }
  return made;
}

UsbBus::~UsbBus() {
  for (libusb_device* device : arrived_devices_) libusb_unref_device(device);
  if (context_ != nullptr) libusb_exit(context_);
}

void UsbBus::handle_events(std::int64_t timeout_us) const {
  timeval timeout{.tv_sec = timeout_us / 1'000'000, .tv_usec = timeout_us % 1'000'000};
  libusb_handle_events_timeout_completed(context_, &timeout, nullptr);
  Pulse::beat();
}

libusb_device* UsbBus::next_arrival() {
  if (arrived_devices_.empty()) return nullptr;
  libusb_device* const device = arrived_devices_.back();
  arrived_devices_.pop_back();
  return device;
}

int LIBUSB_CALL UsbBus::arrived(libusb_context* /*context*/, libusb_device* device,
                                libusb_hotplug_event /*event*/, void* self) {
  // libusb does not allow to open a device here.
  static_cast<UsbBus*>(self)->arrived_devices_.push_back(libusb_ref_device(device));
  return 0;  // keep the callback
}

}  // namespace fanlight
