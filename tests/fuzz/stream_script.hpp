// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fanlight::test {

/// The bytes of a probe's bulk pipe.
struct ScriptedStream {
  std::vector<std::uint8_t> bytes;
  /// Index of the first byte of each transfer after the first one, ascending.
  std::vector<std::size_t> transfer_starts;
};

/// Interprets any bytes as a script that generates a stream. Each command is one byte; its arguments follow:
///   0 n, n bytes    append the n bytes
///   1 a b c d       append a header with valid checksums for 256 a + b pixels of value c, sequence number d
///   2 a b c         append 256 a + b pixels of value c
///   3               begin a new transfer
///   4 a b           flip bit b % 8 of the byte at distance a from the last one
///   5 n             append a header truncated to n % 64 bytes
///   6 a b n         append a header of 64 + n % 193 bytes, as a later minor version may have, for 256 a + b
///                   pixels of value 0
///   7 n             append the first 8 bytes of a header whose length field is 63 + n % 193
/// Command bytes are taken modulo 8. Missing arguments at the end are 0.
ScriptedStream stream_of(std::span<const std::uint8_t> script);

}  // namespace fanlight::test
