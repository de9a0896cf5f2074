#include "tests/fuzz/stream_script.hpp"

#include <algorithm>

#include "proto/crc32c.hpp"
#include "proto/probe_protocol.hpp"

namespace fanlight::test {

namespace {

/// A script from its front; zeros beyond its end.
class Script {
 public:
  explicit Script(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool ended() const { return bytes_.empty(); }
  std::uint8_t byte() {
    if (bytes_.empty()) return 0;
    const std::uint8_t first = bytes_[0];
    bytes_ = bytes_.subspan(1);
    return first;
  }
  std::uint32_t number() {
    const std::uint32_t high = byte();
    return 256 * high + byte();
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

std::size_t length_of(std::uint8_t number) {
  return probe::kFrameHeaderBytes + number % (probe::kMostFrameHeaderBytes - probe::kFrameHeaderBytes + 1);
}

void add_longer_header(std::vector<std::uint8_t>& to, std::uint32_t pixels, std::size_t length) {
  constexpr std::size_t kChecksumBytes = 4;
  const auto header = probe::encode(
      {.payload_bytes = pixels, .payload_crc32c = crc32c(std::vector<std::uint8_t>(pixels, 0))});
  std::vector<std::uint8_t> longer(header.begin(), header.end());
  longer.resize(length - kChecksumBytes);
  longer[6] = static_cast<std::uint8_t>(length);
  longer[7] = static_cast<std::uint8_t>(length >> 8);
  const std::uint32_t crc = crc32c(longer);
  for (int byte = 0; byte < 4; ++byte) longer.push_back(static_cast<std::uint8_t>(crc >> (8 * byte)));
  to.insert(to.end(), longer.begin(), longer.end());
}

}  // namespace

ScriptedStream stream_of(std::span<const std::uint8_t> script) {
  ScriptedStream stream;
  std::vector<std::uint8_t>& to = stream.bytes;
  const auto add_header = [&to](std::uint32_t pixels, std::uint8_t grey, std::uint8_t sequence,
                                std::size_t length) {
    const auto header = probe::encode(
        {.sequence = sequence, .payload_bytes = pixels, .payload_crc32c = crc32c(std::vector(pixels, grey))});
    to.insert(to.end(), header.begin(), header.begin() + static_cast<std::ptrdiff_t>(length));
  };
  for (Script from(script); !from.ended();) {
    switch (from.byte() % 8) {
      case 0:
        for (std::uint8_t left = from.byte(); left > 0 && !from.ended(); --left) to.push_back(from.byte());
        break;
      case 1: {
        const std::uint32_t pixels = from.number();
        const std::uint8_t grey = from.byte();
        add_header(pixels, grey, from.byte(), probe::kFrameHeaderBytes);
        break;
      }
      case 2: {
        const std::uint32_t pixels = from.number();
        to.insert(to.end(), pixels, from.byte());
        break;
      }
      case 3:
        stream.transfer_starts.push_back(to.size());
        break;
      case 4: {
        const std::size_t from_end = from.byte();
        const unsigned bit = from.byte() % 8U;
        if (from_end < to.size()) to[to.size() - 1 - from_end] ^= static_cast<std::uint8_t>(1U << bit);
        break;
      }
      case 5:
        add_header(1, 0, 0, from.byte() % probe::kFrameHeaderBytes);
        break;
      case 6: {
        const std::uint32_t pixels = from.number();
        add_longer_header(to, pixels, length_of(from.byte()));
        break;
      }
      default: {
        const auto length =
            static_cast<std::uint8_t>(length_of(from.byte()) - 1);  // 256 would not fit a byte
        to.insert(to.end(),
                  {probe::kMagic[0], probe::kMagic[1], probe::kMagic[2], probe::kMagic[3], 0, 1, length, 0});
        break;
      }
    }
  }
  return stream;
}

}  // namespace fanlight::test
