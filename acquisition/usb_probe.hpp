#pragma once

#include <libusb.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "acquisition/usb_address.hpp"
#include "proto/counter.hpp"
#include "proto/probe_protocol.hpp"

namespace fanlight {

/// A probe that is plugged in and taken: its requests (proto/usb_probe.md). Each waits for its answer, up to
/// 500 ms, while transfers under way go on; errors are kNotFound where the probe is gone, otherwise
/// kUnavailable (no answer), kInvalidArgument (refused by the probe) or kBadInput. Failures of a probe that
/// is there are counted. One thread.
class UsbProbe {
 public:
  /// Opens a device and takes its probe interface. kNotFound where it is none, or has another serial number;
  /// kUnavailable where it may not be opened or is in use.
  static Result<std::unique_ptr<UsbProbe>> open(libusb_device* device, const UsbAddress& address,
                                                ProbeCounters& counters);
  /// Precondition: no transfer is under way.
  ~UsbProbe();
  UsbProbe(const UsbProbe&) = delete;
  UsbProbe& operator=(const UsbProbe&) = delete;

  libusb_device_handle* handle() const { return handle_; }
  std::uint8_t endpoint() const { return endpoint_; }  ///< of the frames

  Result<probe::Identity> identity();
  Result<probe::Capabilities> capabilities();
  Result<probe::Geometry> geometry();
  Result<probe::Settings> settings();

  Result<void> set(probe::Request setting, std::uint32_t value);
  Result<void> start();
  Result<void> stop();

  /// Ends a halt of the frames' pipe.
  Result<void> clear_halt();
  /// Makes the probe begin anew, as if it had been unplugged for a moment; it may be gone afterwards.
  Result<void> reset();

 private:
  UsbProbe(libusb_device_handle* handle, ProbeCounters& counters) : handle_(handle), counters_(counters) {}
  bool find_interface(libusb_device* device);
  Result<std::span<const std::uint8_t>> ask(probe::Request request);
  Result<void> tell(probe::Request request, std::span<std::uint8_t> data);
  Error failed(const char* what, int failure);

  libusb_device_handle* handle_;
  ProbeCounters& counters_;
  std::uint8_t interface_ = 0;
  std::uint8_t endpoint_ = 0;
  bool claimed_ = false;
  std::array<std::uint8_t, 256> answer_{};
};

}  // namespace fanlight
