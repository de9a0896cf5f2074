// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "acquisition/record/segment.hpp"
#include "tests/fuzz/fuzz_targets.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/require.hpp"

namespace fanlight::test {

void fuzz_segment(std::span<const std::uint8_t> input) {
  if (input.size() < 2) return;
  const std::size_t records = std::min<std::size_t>(input[0] + 256U * input[1], input.size() - 2);
  const MemoryFile frames(input.subspan(2, records));
  const MemoryFile pixels(input.subspan(2 + records));
  const auto segment = read_segment({.frames = frames.path(), .pixels = pixels.path(), .pictures = {}});
  if (!segment) {
    require(!segment.error().message.empty(), "a refusal has a message");
    return;
  }
  const std::uint64_t bytes = segment->frames.size() * segment->facts.geometry.frame_bytes();
  require(bytes <= input.size() - 2 - records, "the pixels of each frame are there");
  require(segment->frames.size() == segment->pixel_checksums.size(), "each frame has a checksum");
}

}  // namespace fanlight::test
