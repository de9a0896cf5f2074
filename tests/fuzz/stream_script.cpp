// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/stream_script.hpp"

#include <algorithm>

#include "proto/base/crc32c.hpp"
#include "proto/model/probe_protocol.hpp"

namespace fanlight::test {

namespace {

/// Reads a script from its front; returns zeros beyond its end.
class ScriptReader {
 public:
  explicit ScriptReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool ended() const { return bytes_.empty(); }
  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t first = bytes_[0];
    bytes_ = bytes_.subspan(1);
    return first;
  }
  /// 16 bit, high byte first.
  std::uint32_t number() {
    const std::uint32_t high = byte();
    return 256 * high + byte();
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// 64 to 256 bytes.
std::size_t header_length(std::uint8_t number) {
  return probe::kFrameHeaderBytes + number % (probe::kMostFrameHeaderBytes - probe::kFrameHeaderBytes + 1);
}

/// Appends a header with valid checksums for `pixels` bytes of 0, padded with zeros to `length` bytes.
void add_longer_header(std::vector<std::uint8_t>& bytes, std::uint32_t pixels, std::size_t length) {
  constexpr std::size_t kChecksumBytes = 4;
  const auto header = probe::encode(
      {.payload_bytes = pixels, .payload_crc32c = crc32c(std::vector<std::uint8_t>(pixels, 0))});
  std::vector<std::uint8_t> longer(header.begin(), header.end());
  longer.resize(length - kChecksumBytes);
  longer[6] = static_cast<std::uint8_t>(length);
  longer[7] = static_cast<std::uint8_t>(length >> 8);
  const std::uint32_t crc = crc32c(longer);
  for (int byte = 0; byte < 4; ++byte) longer.push_back(static_cast<std::uint8_t>(crc >> (8 * byte)));
  bytes.insert(bytes.end(), longer.begin(), longer.end());
}

}  // namespace

ScriptedStream stream_of(std::span<const std::uint8_t> script) {
  ScriptedStream stream;
  std::vector<std::uint8_t>& bytes = stream.bytes;
  const auto add_header = [&bytes](std::uint32_t pixels, std::uint8_t grey, std::uint8_t sequence,
                                   std::size_t length) {
    const auto header = probe::encode(
        {.sequence = sequence, .payload_bytes = pixels, .payload_crc32c = crc32c(std::vector(pixels, grey))});
    bytes.insert(bytes.end(), header.begin(), header.begin() + static_cast<std::ptrdiff_t>(length));
  };
  for (ScriptReader reader(script); !reader.ended();) {
    switch (reader.byte() % 8) {
      case 0:
        for (std::uint8_t left = reader.byte(); left > 0 && !reader.ended(); --left)
          bytes.push_back(reader.byte());
        break;
      case 1: {
        const std::uint32_t pixels = reader.number();
        const std::uint8_t grey = reader.byte();
        add_header(pixels, grey, reader.byte(), probe::kFrameHeaderBytes);
        break;
      }
      case 2: {
        const std::uint32_t pixels = reader.number();
        bytes.insert(bytes.end(), pixels, reader.byte());
        break;
      }
      case 3:
        stream.transfer_starts.push_back(bytes.size());
        break;
      case 4: {
        const std::size_t from_end = reader.byte();
        const unsigned bit = reader.byte() % 8U;
        if (from_end < bytes.size())
          bytes[bytes.size() - 1 - from_end] ^= static_cast<std::uint8_t>(1U << bit);
        break;
      }
      case 5:
        add_header(1, 0, 0, reader.byte() % probe::kFrameHeaderBytes);
        break;
      case 6: {
        const std::uint32_t pixels = reader.number();
        add_longer_header(bytes, pixels, header_length(reader.byte()));
        break;
      }
      default: {
        // Minus 1, because 256 does not fit in a byte.
        const auto length = static_cast<std::uint8_t>(header_length(reader.byte()) - 1);
        bytes.insert(bytes.end(), {probe::kMagic[0], probe::kMagic[1], probe::kMagic[2], probe::kMagic[3], 0,
                                   1, length, 0});
        break;
      }
    }
  }
  return stream;
}

}  // namespace fanlight::test
