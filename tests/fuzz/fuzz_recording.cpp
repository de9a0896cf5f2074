// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "acquisition/replay/recording.hpp"
#include "tests/fuzz/fuzz_targets.hpp"
#include "tests/fuzz/memory_file.hpp"
#include "tests/fuzz/require.hpp"

namespace fanlight::test {

void fuzz_recording(std::span<const std::uint8_t> input) {
  constexpr std::uint64_t kMostBytes = 1 << 24;
  const MemoryFile file(input);
  auto recording = Recording::open({.path = file.path(),
                                    .geometry_path = {},
                                    .max_bytes = kMostBytes,
                                    .pixels = Recording::Pixels::kFromFile});
  if (!recording) {
    require(!recording.error().message.empty(), "a refusal has a message");
    return;
  }
  const RecordingSummary& summary = recording->summary();
  require(summary.frames >= 2 && recording->frames().size() == summary.frames, "it has frames");
  std::uint64_t of_sweeps = 0;
  for (const Recording::Sweep& sweep : recording->sweeps()) {
    require(sweep.first_frame == of_sweeps, "a sweep begins behind the one before");
    of_sweeps += sweep.frames;
  }
  require(of_sweeps == summary.frames, "each frame is in a sweep");
  std::vector<std::uint8_t> pixels(summary.geometry.frame_bytes());
  for (std::size_t frame = 0; frame < summary.frames; ++frame) {
    if (!recording->read_frame(frame, pixels)) return;
  }
  (void)recording->finish();
}

}  // namespace fanlight::test
