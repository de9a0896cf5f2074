#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace fanlight {

/// A SHA-256 (FIPS 180-4).
using Digest = std::array<std::uint8_t, 32>;

Digest sha256(std::string_view bytes);

/// Whether two digests are the same, in a time that does not tell where they differ.
bool same_digest(const Digest& a, const Digest& b);

/// Lower case, two digits a byte.
std::string hex(std::span<const std::uint8_t> bytes);
std::optional<Digest> digest_from_hex(std::string_view text);

/// Bytes that nobody can guess, from the system's generator. Ends the process where it has none.
void fill_random(std::span<std::uint8_t> bytes);

}  // namespace fanlight
