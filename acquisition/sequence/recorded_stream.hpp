// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/sequence/frame_sequence.hpp"
#include "acquisition/sequence/recorded_frame.hpp"

namespace fanlight {

/// What Fanlight's recorder wrote about the frames of a sequence: with it, a replay gives the assembler the
/// same stamps as the source did.
struct RecordedStream {
  RecordingFacts facts;  ///< but for the geometry: see find_geometry()
  std::vector<RecordedFrame> frames;

  std::uint64_t smallest_sequence = 0;
  std::uint64_t smallest_volume_index = 0;
};

/// What fields named Fanlight... say of all frames, but for the geometry. nullopt where one is missing.
std::optional<RecordingFacts> recording_facts(
    const std::map<std::string, std::string, std::less<>>& fanlight_fields);

/// nullopt where a field is missing: the sequence was not written by Fanlight, or was changed by hand. Its
/// frames are then read as any other's.
std::optional<RecordedStream> recorded_stream(const FrameSequence& sequence);

}  // namespace fanlight
