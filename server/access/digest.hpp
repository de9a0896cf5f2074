// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace fanlight {

/// A SHA-256 digest (FIPS 180-4).
using Digest = std::array<std::uint8_t, 32>;

Digest sha256(std::string_view bytes);

/// Compares two digests in a time that does not depend on where they differ.
bool same_digest(const Digest& a, const Digest& b);

/// Lower case, two digits for each byte.
std::string hex(std::span<const std::uint8_t> bytes);
std::optional<Digest> digest_from_hex(std::string_view text);

/// Writes random bytes from the cryptographic generator of the system. Ends the process if there is none.
void fill_random(std::span<std::uint8_t> bytes);

}  // namespace fanlight
