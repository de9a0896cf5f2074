// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/usb_address.hpp"

#include <fmt/format.h>

#include <charconv>

#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

bool read_hexadecimal(std::string_view text, std::uint16_t& number) {
  const char* const end = text.data() + text.size();
  const auto [stopped, failure] = std::from_chars(text.data(), end, number, 16);
  return failure == std::errc{} && stopped == end && text.size() <= 4;
}

}  // namespace

Result<UsbAddress> UsbAddress::parse(std::string_view text) {
  const std::size_t first = text.find(':');
  const std::size_t second = first == text.npos ? text.npos : text.find(':', first + 1);
  UsbAddress address;
  const bool numbers = first != text.npos && read_hexadecimal(text.substr(0, first), address.vendor) &&
                       read_hexadecimal(text.substr(first + 1, second - first - 1), address.product);
  const bool named = second == text.npos || second + 1 < text.size();
  if (!numbers || !named) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the USB device is {}, expected VENDOR:PRODUCT[:SERIAL] in hexadecimal, such as "
                             "usb:1209:0001 or usb:1209:0001:A7",
                             in_quotes(text))};
  }
  if (second != text.npos) address.serial = text.substr(second + 1);
  return address;
}

std::string UsbAddress::text() const {
  return fmt::format("usb:{:04x}:{:04x}{}{}", vendor, product, serial.empty() ? "" : ":", serial);
}

}  // namespace fanlight
