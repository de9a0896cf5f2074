// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/igtl_address.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>

#include "acquisition/source/printable.hpp"
#include "proto/base/nearest_name.hpp"
#include "proto/igtl/message_head.hpp"

namespace fanlight {

namespace {

constexpr std::string_view kOptions[] = {"image", "transform", "orientation"};

Error bad(std::string_view wrong, std::string_view expected) {
  return {ErrorCode::kInvalidArgument, fmt::format("{}, expected {}", wrong, expected)};
}

bool is_host(std::string_view host) {
  return !host.empty() && host.size() <= 255 && std::ranges::all_of(host, [](char each) {
    return std::isalnum(static_cast<unsigned char>(each)) != 0 ||
           std::string_view(".-_:%").find(each) != std::string_view::npos;
  });
}

Result<void> take_place(std::string_view text, IgtlAddress& address) {
  std::string_view port;
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    if (end == std::string_view::npos) return bad(fmt::format("{} has no ]", in_quotes(text)), "[ADDRESS]");
    address.host = text.substr(1, end - 1);
    port = text.substr(end + 1);
    if (!port.empty() && port.front() != ':') return bad("text follows the ]", "a colon and a port");
  } else {
    const std::size_t colon = text.find(':');
    if (colon != text.rfind(':'))
      return bad(fmt::format("{} has two colons", in_quotes(text)), "HOST:PORT, or [ADDRESS]:PORT for IPv6");
    address.host = text.substr(0, colon);
    port = colon == std::string_view::npos ? std::string_view() : text.substr(colon);
  }
  if (!is_host(address.host))
    return bad(fmt::format("the host is {}", in_quotes(address.host)), "a name or an address");
  if (port.empty()) {
    address.port = std::to_string(igtl::kUsualPort);
    return {};
  }
  const auto number = number_in<std::uint16_t>(port.substr(1));
  if (!number || *number == 0)
    return bad(fmt::format("the port is {}", in_quotes(port.substr(1))), "1 to 65535");
  address.port = std::to_string(*number);
  return {};
}

Result<void> take_option(std::string_view option, IgtlAddress& address) {
  const std::size_t equals = option.find('=');
  const std::string_view name = option.substr(0, equals);
  const std::string_view value = equals == std::string_view::npos ? "" : option.substr(equals + 1);
  if (value.empty() && std::ranges::find(kOptions, name) != std::end(kOptions))
    return bad(fmt::format("{} has no value", name), fmt::format("{}=VALUE", name));
  if (name == "orientation") {
    const auto orientation = ImageOrientation::from_letters(value);
    if (!orientation)
      return bad(fmt::format("the orientation is {}", in_quotes(value)), "MF, MN, UF, UN, FM, FU, NM or NU");
    address.orientation = *orientation;
    return {};
  }
  if (name == "image" || name == "transform") {
    if (value.size() > igtl::kNameLength)
      return bad(fmt::format("the name {} is too long", in_quotes(value)), "up to 20 characters");
    (name == "image" ? address.image : address.transform) = value;
    return {};
  }
  const std::string meant = nearest_name(name, {std::begin(kOptions), std::end(kOptions)});
  return bad(fmt::format("there is no option {}{}", in_quotes(name),
                         meant.empty() ? "" : fmt::format(", did you mean {}?", meant)),
             "image, transform or orientation");
}

}  // namespace

Result<IgtlAddress> IgtlAddress::parse(std::string_view text) {
  const auto failed = [](const Error& error) {
    return Error{error.code, fmt::format("igtl: {}", error.message)};
  };
  IgtlAddress address;
  std::size_t comma = text.find(',');
  if (auto taken = take_place(text.substr(0, comma), address); !taken) return failed(taken.error());
  while (comma != std::string_view::npos) {
    text.remove_prefix(comma + 1);
    comma = text.find(',');
    if (auto taken = take_option(text.substr(0, comma), address); !taken) return failed(taken.error());
  }
  return address;
}

std::string IgtlAddress::text() const {
  const bool brackets = host.find(':') != std::string::npos;
  return brackets ? fmt::format("igtl:[{}]:{}", host, port) : fmt::format("igtl:{}:{}", host, port);
}

}  // namespace fanlight
