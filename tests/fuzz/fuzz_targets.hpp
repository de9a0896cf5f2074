// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace fanlight::test {

// Fuzz targets. libFuzzer calls them with generated inputs, corpus_test.cpp with the stored ones. Each aborts
// the process if a condition does not hold (require.hpp).

/// Tests FrameParser. The input is a script that generates a stream (stream_script.hpp), so that the fuzzer
/// passes the checksums. Checks for every stream: each frame that begins ends exactly once, no byte is
/// written outside the pixels of a frame, no byte outside the input is read, and the result does not depend
/// on how a transfer is divided into pieces.
void fuzz_frame_parser(std::span<const std::uint8_t> input);

/// Tests the decoders of the blocks that a probe sends. Each block is either refused with a message, or
/// decoded such that encoding and decoding it again gives the same values.
void fuzz_probe_blocks(std::span<const std::uint8_t> input);

/// Tests the messages of a client, as a ClientMessage and as the JSON of the REST API. Each is either refused
/// with a message, or accepted such that scene and stream settings are valid and are unchanged after
/// conversion to a message (the scene also to JSON) and back.
void fuzz_client_messages(std::span<const std::uint8_t> input);

/// Tests the readers of recordings: MetaImage and NRRD sequences, with their pixels. A file is either refused
/// with a message, or gives frames and sweeps that fit each other.
void fuzz_recording(std::span<const std::uint8_t> input);

/// Tests the reader of a recording that was cut off. The first two bytes are the length of the file with the
/// records; the rest are the pixels. It is either refused with a message, or gives frames that are there.
void fuzz_segment(std::span<const std::uint8_t> input);

}  // namespace fanlight::test
