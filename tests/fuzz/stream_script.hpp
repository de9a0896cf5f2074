#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fanlight::test {

/// A byte stream and where its transfers begin.
struct ScriptedStream {
  std::vector<std::uint8_t> bytes;
  std::vector<std::size_t> transfer_starts;  ///< ascending
};

/// Any bytes, read as orders to put a stream together; each order is one byte, and what it takes follows:
///   0 n, n bytes          the bytes as they are
///   1 a b c d             a header with right checksums for 256 a + b pixels of c, its sequence number d
///   2 a b c               256 a + b pixels of c
///   3                     a new transfer
///   4 a b                 bit b % 8 of the byte a from the end is flipped
///   5 n                   a header cut off after n % 64 bytes
///   6 a b n               a header of 64 + n % 193 bytes, as a later minor version may have, for 256 a + b
///   pixels of 0 7 n                   what begins like a header of 64 + n % 193 bytes
/// Other orders are taken modulo 8; what is missing at the end counts as 0.
ScriptedStream stream_of(std::span<const std::uint8_t> script);

}  // namespace fanlight::test
