#pragma once

#include <cstdint>
#include <span>

namespace fanlight::test {

// What libFuzzer calls with bytes that it makes up, and the corpus test with those that are kept. Each ends
// the process where something does not hold.

/// FrameParser. The input is a script that puts a stream together (stream_script.hpp), so that the fuzzer
/// gets past the checksums. Whatever comes: each frame that begins ends once, no pixel is written beside its
/// place, no byte beside those given is read, and it does not matter how the bytes of a transfer are divided.
void fuzz_frame_parser(std::span<const std::uint8_t> input);

/// The blocks that a probe answers: refused with a sentence, or read so that encoding them and reading them
/// again gives the same.
void fuzz_probe_blocks(std::span<const std::uint8_t> input);

/// What a display says, as a ClientMessage and as a script's JSON: refused with a sentence, or taken so that
/// the scene and the stream are ones that may be, and telling of them and reading that gives the same.
void fuzz_client_messages(std::span<const std::uint8_t> input);

}  // namespace fanlight::test
