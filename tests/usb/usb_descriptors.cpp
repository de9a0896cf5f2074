// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/usb_descriptors.hpp"

#include "proto/model/probe_protocol.hpp"

namespace fanlight::test {

namespace {

using Bytes = std::vector<std::uint8_t>;

enum Type : std::uint8_t { kDevice = 1, kConfiguration = 2, kString = 3, kInterface = 4, kEndpoint = 5 };
enum StringIndex : std::uint8_t { kLanguages = 0, kManufacturer = 1, kProduct = 2, kSerial = 3 };

constexpr std::uint8_t low(unsigned value) {
  return static_cast<std::uint8_t>(value & 0xFF);
}
constexpr std::uint8_t high(unsigned value) {
  return static_cast<std::uint8_t>(value >> 8);
}

Bytes device() {
  constexpr unsigned kUsbVersion = 0x0200;
  constexpr unsigned kRelease = 0x0100;
  constexpr std::uint8_t kControlPacketBytes = 64;
  return {18,
          kDevice,
          low(kUsbVersion),
          high(kUsbVersion),
          0,
          0,
          0,
          kControlPacketBytes,
          low(kEmulatedVendor),
          high(kEmulatedVendor),
          low(kEmulatedProduct),
          high(kEmulatedProduct),
          low(kRelease),
          high(kRelease),
          kManufacturer,
          kProduct,
          kSerial,
          1};
}

Bytes configuration() {
  constexpr unsigned kPacketBytes = 512;
  constexpr std::uint8_t kBulk = 2;
  constexpr std::uint8_t kSelfPowered = 0xC0;
  return {9,
          kConfiguration,
          9 + 9 + 7,
          0,
          1,
          1,
          0,
          kSelfPowered,
          0,
          9,
          kInterface,
          0,
          0,
          1,
          probe::kInterfaceClass,
          probe::kInterfaceSubclass,
          probe::kInterfaceProtocol,
          0,
          7,
          kEndpoint,
          kEmulatedBulkEndpoint,
          kBulk,
          low(kPacketBytes),
          high(kPacketBytes),
          0};
}

Bytes string(const std::string& ascii) {
  Bytes bytes = {static_cast<std::uint8_t>(2 + 2 * ascii.size()), kString};
  for (const char character : ascii) {
    bytes.push_back(static_cast<std::uint8_t>(character));
    bytes.push_back(0);  // UTF-16
  }
  return bytes;
}

}  // namespace

Bytes device_and_configuration() {
  Bytes all = device();
  const Bytes more = configuration();
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

std::optional<Bytes> descriptor(std::uint16_t value, const std::string& serial) {
  constexpr unsigned kUsEnglish = 0x0409;
  const std::uint8_t index = low(value);
  switch (high(value)) {
    case kDevice:
      return device();
    case kConfiguration:
      return index == 0 ? std::optional(configuration()) : std::nullopt;
    case kString:
      switch (index) {
        case kLanguages:
          return Bytes{4, kString, low(kUsEnglish), high(kUsEnglish)};
        case kManufacturer:
          return string("Fanlight");
        case kProduct:
          return string("Emulated probe");
        case kSerial:
          return string(serial);
        default:
          return std::nullopt;
      }
    default:
      return std::nullopt;
  }
}

}  // namespace fanlight::test
