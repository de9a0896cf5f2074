// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "acquisition/usb/frame_parser.hpp"
#include "tests/fuzz/fuzz_targets.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/fuzz/stream_script.hpp"

namespace fanlight::test {

namespace {

using Event = FrameParser::Event;

/// All results of a parser for one stream.
struct ParserOutput {
  std::vector<Event> events;
  std::vector<std::uint64_t> sequences;
  std::vector<std::uint8_t> pixels;  // of the frames that ended with kWhole
  std::uint64_t skipped = 0;

  bool operator==(const ParserOutput&) const = default;
};

/// Passes a stream to a parser in pieces of at most `piece_bytes` and checks the order of its events.
class ParserRun {
 public:
  ParserRun(const ScriptedStream& stream, std::size_t piece_bytes)
      : stream_(stream), piece_bytes_(piece_bytes) {}

  ParserOutput run() {
    std::size_t begin = 0;
    for (std::size_t transfer = 0; transfer <= stream_.transfer_starts.size(); ++transfer) {
      const bool last = transfer == stream_.transfer_starts.size();
      const std::size_t end = last ? stream_.bytes.size() : stream_.transfer_starts[transfer];
      // The first header of a transfer must lie completely in the first piece; it has up to 256 bytes.
      for (std::size_t size = std::max<std::size_t>(piece_bytes_, 256); begin < end; size = piece_bytes_) {
        const std::size_t next = std::min(end, begin + size);
        parse_piece(std::span(stream_.bytes).subspan(begin, next - begin));
        begin = next;
      }
      if (!last) parser_.begin_transfer();
    }
    output_.skipped = parser_.bytes_skipped();
    require(output_.skipped <= stream_.bytes.size(), "no byte is skipped twice");
    return output_;
  }

 private:
  static constexpr std::uint8_t kGuard = 0xA5;

  void parse_piece(std::span<const std::uint8_t> piece) {
    // A copy in an allocation of exactly this size: the address sanitizer detects a read outside it.
    const std::vector<std::uint8_t> copy(piece.begin(), piece.end());
    std::span<const std::uint8_t> bytes = copy;
    for (;;) {
      const std::size_t before = bytes.size();
      const Event event = parser_.next(bytes);
      require(bytes.size() <= before, "next() never lengthens its input");
      if (event == Event::kMore) {
        require(bytes.empty(), "kMore follows only when all bytes are used");
        return;
      }
      record(event);
    }
  }

  void record(Event event) {
    output_.events.push_back(event);
    require(in_frame_ == (event != Event::kFrame), "a frame begins only after the previous one ended");
    if (event == Event::kFrame) {
      output_.sequences.push_back(parser_.header().sequence);
      // Pixels of frames with an odd sequence number are not requested.
      requested_ = parser_.header().sequence % 2 == 0;
      frame_.assign(parser_.header().payload_bytes + 1, kGuard);
      if (requested_) parser_.take_pixels(std::span(frame_).first(frame_.size() - 1));
    } else {
      require(frame_.back() == kGuard, "no byte is written after the last pixel");
      if (requested_ && event == Event::kWhole) {
        require(crc32c(std::span(frame_).first(frame_.size() - 1)) == parser_.header().payload_crc32c,
                "the pixels of a whole frame match its checksum");
        output_.pixels.insert(output_.pixels.end(), frame_.begin(), frame_.end() - 1);
      }
    }
    in_frame_ = event == Event::kFrame;
    require(parser_.in_frame() == in_frame_, "in_frame() is true between the begin and the end of a frame");
  }

  const ScriptedStream& stream_;
  std::size_t piece_bytes_;
  FrameParser parser_;
  ParserOutput output_;
  std::vector<std::uint8_t> frame_;
  bool in_frame_ = false;
  bool requested_ = false;
};

}  // namespace

void fuzz_frame_parser(std::span<const std::uint8_t> input) {
  if (input.empty()) return;
  const ScriptedStream stream = stream_of(input.subspan(1));
  constexpr std::size_t kMostBytes = 1 << 20;
  if (stream.bytes.size() > kMostBytes) return;
  const ParserOutput whole = ParserRun(stream, stream.bytes.size() + 1).run();
  const ParserOutput divided = ParserRun(stream, 1 + input[0]).run();
  require(whole == divided, "the result does not depend on how a transfer is divided into pieces");
}

}  // namespace fanlight::test
