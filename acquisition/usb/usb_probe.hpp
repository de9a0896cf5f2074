// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libusb.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "acquisition/usb/usb_address.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "proto/model/probe_protocol.hpp"

namespace fanlight {

/// Requests to an open probe (proto/usb_probe.md). Each blocks until its answer, up to 500 ms; pending
/// transfers continue meanwhile. Errors: kNotFound where the probe is gone, otherwise kUnavailable (no
/// answer), kInvalidArgument (refused by the probe) or kBadInput. Failures of a probe that is plugged in are
/// counted. One thread.
class UsbProbe {
 public:
  /// Opens a device and claims its probe interface. kNotFound: it is no probe, or has another serial number;
  /// kUnavailable: it may not be opened, or is in use.
  static Result<std::unique_ptr<UsbProbe>> open(libusb_device* device, const UsbAddress& address,
                                                ProbeCounters& counters);
  /// Precondition: no transfer is pending.
  ~UsbProbe();
  UsbProbe(const UsbProbe&) = delete;
  UsbProbe& operator=(const UsbProbe&) = delete;

  libusb_device_handle* handle() const { return handle_; }
  std::uint8_t endpoint() const { return endpoint_; }  ///< of the bulk pipe

  Result<probe::Identity> identity();
  Result<probe::Capabilities> capabilities();
  Result<probe::Geometry> geometry();
  Result<probe::Settings> settings();

  Result<void> set(probe::Request setting, std::uint32_t value);
  Result<void> start();
  Result<void> stop();

  /// Clears a halt of the bulk pipe.
  Result<void> clear_halt();
  /// Resets the probe, with the effect of a short unplug; it may be gone afterwards.
  Result<void> reset();

 private:
  UsbProbe(libusb_device_handle* handle, ProbeCounters& counters) : handle_(handle), counters_(counters) {}
  bool find_interface(libusb_device* device);
  Result<std::span<const std::uint8_t>> request_in(probe::Request request);
  Result<void> request_out(probe::Request request, std::span<std::uint8_t> data);
  Error failed(const char* what, int failure);

  libusb_device_handle* handle_;
  ProbeCounters& counters_;
  std::uint8_t interface_ = 0;
  std::uint8_t endpoint_ = 0;
  bool claimed_ = false;
  std::array<std::uint8_t, 256> answer_{};
};

}  // namespace fanlight
