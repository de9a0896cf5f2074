// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// Address of a USB device.
struct UsbAddress {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string serial;  ///< empty: any

  /// "1209:0001" or "1209:0001:SERIAL", with hexadecimal numbers as lsusb prints them.
  static Result<UsbAddress> parse(std::string_view text);

  /// "usb:1209:0001:SERIAL".
  std::string text() const;
};

}  // namespace fanlight
