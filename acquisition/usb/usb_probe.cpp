// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/usb_probe.hpp"

#include <fmt/format.h>

namespace fanlight {

namespace {

constexpr unsigned kRequestTimeoutMs = 500;
// bmRequestType: a vendor request to an interface (USB 2.0, table 9-2).
constexpr std::uint8_t kIn = 0xC1;
constexpr std::uint8_t kOut = 0x41;

ErrorCode code_of(int failure) {
  switch (failure) {
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
      return ErrorCode::kNotFound;
    case LIBUSB_ERROR_PIPE:
      return ErrorCode::kInvalidArgument;
    default:
      return ErrorCode::kUnavailable;
  }
}

std::string serial_of(libusb_device* device, libusb_device_handle* handle) {
  libusb_device_descriptor descriptor{};
  std::array<unsigned char, 128> text{};
  if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS || descriptor.iSerialNumber == 0)
    return {};
  const int length =
      libusb_get_string_descriptor_ascii(handle, descriptor.iSerialNumber, text.data(), text.size());
  if (length <= 0) return {};
  return {text.begin(), text.begin() + length};
}

}  // namespace

Result<std::unique_ptr<UsbProbe>> UsbProbe::open(libusb_device* device, const UsbAddress& address,
                                                 ProbeCounters& counters) {
  libusb_device_handle* handle = nullptr;
  if (const int failure = libusb_open(device, &handle); failure != LIBUSB_SUCCESS) {
    const char* const expected =
        failure == LIBUSB_ERROR_ACCESS
            ? "the right to write to its node under /dev/bus/usb, as deploy/60-fanlight-probe.rules gives it"
            : "a device that stays connected";
    return Error{code_of(failure), fmt::format("{} was found but could not be opened ({}), expected {}",
                                               address.text(), libusb_strerror(failure), expected)};
  }
  std::unique_ptr<UsbProbe> made(new UsbProbe(handle, counters));
  if (!address.serial.empty()) {
    const std::string serial = serial_of(device, handle);
    if (serial != address.serial) {
      return Error{ErrorCode::kNotFound,
                   fmt::format("the device found has the serial number \"{}\", expected \"{}\"", serial,
                               address.serial)};
    }
  }
  if (!made->find_interface(device)) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{} is not a probe, expected an interface of class ff, subclass 46, "
                             "protocol 01 with a bulk IN endpoint",
                             address.text())};
  }
  if (const int failure = libusb_claim_interface(handle, made->interface_); failure != LIBUSB_SUCCESS) {
    const ErrorCode code = failure == LIBUSB_ERROR_BUSY ? ErrorCode::kUnavailable : code_of(failure);
    return Error{code, fmt::format("{} could not be claimed ({}), expected that no other program uses it",
                                   address.text(), libusb_strerror(failure))};
  }
  made->claimed_ = true;
  return made;
}

UsbProbe::~UsbProbe() {
  if (claimed_) libusb_release_interface(handle_, interface_);
  libusb_close(handle_);
}

bool UsbProbe::find_interface(libusb_device* device) {
  libusb_config_descriptor* config = nullptr;
  if (libusb_get_active_config_descriptor(device, &config) != LIBUSB_SUCCESS) return false;
  bool found = false;
  for (int number = 0; number < config->bNumInterfaces && !found; ++number) {
    const libusb_interface& interface = config->interface[number];
    if (interface.num_altsetting < 1) continue;
    const libusb_interface_descriptor& setting = interface.altsetting[0];
    if (setting.bInterfaceClass != probe::kInterfaceClass ||
        setting.bInterfaceSubClass != probe::kInterfaceSubclass ||
        setting.bInterfaceProtocol != probe::kInterfaceProtocol) {
      continue;
    }
    for (int index = 0; index < setting.bNumEndpoints && !found; ++index) {
      const libusb_endpoint_descriptor& endpoint = setting.endpoint[index];
      constexpr int kTypeMask = 3;
      if ((endpoint.bmAttributes & kTypeMask) != LIBUSB_ENDPOINT_TRANSFER_TYPE_BULK) continue;
      if ((endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) == 0) continue;
      interface_ = setting.bInterfaceNumber;
      endpoint_ = endpoint.bEndpointAddress;
      found = true;
    }
  }
  libusb_free_config_descriptor(config);
  return found;
}

Error UsbProbe::failed(const char* what, int failure) {
  const ErrorCode code = code_of(failure);
  if (code != ErrorCode::kNotFound) counters_.requests_failed.add();  // not of a probe that is gone
  if (code == ErrorCode::kInvalidArgument) {
    return {code,
            fmt::format("the probe refused {}, expected one that it knows and a value that it offers", what)};
  }
  return Error{code, fmt::format("the probe did not answer {} ({}), expected an answer within {} ms", what,
                                 libusb_strerror(failure), kRequestTimeoutMs)};
}

Result<std::span<const std::uint8_t>> UsbProbe::request_in(probe::Request request) {
  const int length =
      libusb_control_transfer(handle_, kIn, static_cast<std::uint8_t>(request), 0, interface_, answer_.data(),
                              static_cast<std::uint16_t>(answer_.size()), kRequestTimeoutMs);
  if (length < 0) return failed("a question", length);
  return std::span<const std::uint8_t>(answer_).first(static_cast<std::size_t>(length));
}

Result<void> UsbProbe::request_out(probe::Request request, std::span<std::uint8_t> data) {
  const int length =
      libusb_control_transfer(handle_, kOut, static_cast<std::uint8_t>(request), 0, interface_, data.data(),
                              static_cast<std::uint16_t>(data.size()), kRequestTimeoutMs);
  if (length < 0) return failed("an order", length);
  return {};
}

Result<probe::Identity> UsbProbe::identity() {
  const auto block = request_in(probe::Request::kIdentity);
  if (!block) return block.error();
  return probe::decode_identity(*block);
}

Result<probe::Capabilities> UsbProbe::capabilities() {
  const auto block = request_in(probe::Request::kCapabilities);
  if (!block) return block.error();
  return probe::decode_capabilities(*block);
}

Result<probe::Geometry> UsbProbe::geometry() {
  const auto block = request_in(probe::Request::kGeometry);
  if (!block) return block.error();
  return probe::decode_geometry(*block);
}

Result<probe::Settings> UsbProbe::settings() {
  const auto block = request_in(probe::Request::kSettings);
  if (!block) return block.error();
  return probe::decode_settings(*block);
}

Result<void> UsbProbe::set(probe::Request setting, std::uint32_t value) {
  std::array<std::uint8_t, 4> data{};
  for (std::size_t byte = 0; byte < data.size(); ++byte)
    data[byte] = static_cast<std::uint8_t>(value >> (8 * byte));
  return request_out(setting, data);
}

Result<void> UsbProbe::start() {
  return request_out(probe::Request::kStart, {});
}

Result<void> UsbProbe::stop() {
  return request_out(probe::Request::kStop, {});
}

Result<void> UsbProbe::clear_halt() {
  const int failure = libusb_clear_halt(handle_, endpoint_);
  if (failure != LIBUSB_SUCCESS) return failed("the end of a halt", failure);
  return {};
}

Result<void> UsbProbe::reset() {
  const int failure = libusb_reset_device(handle_);
  if (failure != LIBUSB_SUCCESS) return failed("a reset", failure);
  return {};
}

}  // namespace fanlight
