// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace fanlight::test {

// USB descriptors of the emulated probe: high speed, one vendor interface with one bulk IN endpoint.
inline constexpr std::uint16_t kEmulatedVendor = 0x1209;   ///< pid.codes
inline constexpr std::uint16_t kEmulatedProduct = 0x0001;  ///< reserved for tests
inline constexpr std::uint8_t kEmulatedBulkEndpoint = 0x81;

/// The device and configuration descriptors, as the kernel shows them in sysfs.
std::vector<std::uint8_t> device_and_configuration();

/// The answer to GET_DESCRIPTOR; nullopt: none, STALL. `value` is wValue: type and index. The string with
/// index 3 is `serial`, in ASCII.
std::optional<std::vector<std::uint8_t>> descriptor(std::uint16_t value, const std::string& serial);

}  // namespace fanlight::test
