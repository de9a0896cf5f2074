#include <vector>

#include "acquisition/frame_parser.hpp"
#include "tests/fuzz/fuzz_targets.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/fuzz/stream_script.hpp"

namespace fanlight::test {

namespace {

using Event = FrameParser::Event;

/// What a parser says of a stream.
struct Story {
  std::vector<Event> events;
  std::vector<std::uint64_t> sequences;
  std::vector<std::uint8_t> pixels;  // of the frames that came whole
  std::uint64_t skipped = 0;

  bool operator==(const Story&) const = default;
};

/// Gives the parser the stream, at most `piece` bytes at a time.
class Reading {
 public:
  Reading(const ScriptedStream& stream, std::size_t piece) : stream_(stream), piece_(piece) {}

  Story run() {
    std::size_t at = 0;
    for (std::size_t transfer = 0; transfer <= stream_.transfer_starts.size(); ++transfer) {
      const bool last = transfer == stream_.transfer_starts.size();
      const std::size_t end = last ? stream_.bytes.size() : stream_.transfer_starts[transfer];
      // A transfer's first header is found where it lies whole in the first piece.
      for (std::size_t size = piece_ < 256 ? 256 : piece_; at < end; size = piece_) {
        const std::size_t next = std::min(end, at + size);
        give(std::span(stream_.bytes).subspan(at, next - at));
        at = next;
      }
      if (!last) parser_.begin_transfer();
    }
    story_.skipped = parser_.bytes_skipped();
    require(story_.skipped <= stream_.bytes.size(), "no byte is skipped twice");
    return story_;
  }

 private:
  static constexpr std::uint8_t kGuard = 0xA5;

  void give(std::span<const std::uint8_t> piece) {
    // In memory of its own size, so that a sanitizer sees a step beside it.
    const std::vector<std::uint8_t> copy(piece.begin(), piece.end());
    std::span<const std::uint8_t> bytes = copy;
    for (;;) {
      const std::size_t before = bytes.size();
      const Event event = parser_.next(bytes);
      require(bytes.size() <= before, "bytes are used from the front");
      if (event == Event::kMore) {
        require(bytes.empty(), "more is asked for when all was used");
        return;
      }
      tell(event);
    }
  }

  void tell(Event event) {
    story_.events.push_back(event);
    require(in_frame_ == (event != Event::kFrame), "a frame begins after the last one ended");
    if (event == Event::kFrame) {
      story_.sequences.push_back(parser_.header().sequence);
      // Every other frame is passed over.
      taken_ = parser_.header().sequence % 2 == 0;
      frame_.assign(parser_.header().payload_bytes + 1, kGuard);
      if (taken_) parser_.take_pixels(std::span(frame_).first(frame_.size() - 1));
    } else {
      require(frame_.back() == kGuard, "no pixel is written after the last");
      if (taken_ && event == Event::kWhole) {
        require(crc32c(std::span(frame_).first(frame_.size() - 1)) == parser_.header().payload_crc32c,
                "a whole frame's pixels have its checksum");
        story_.pixels.insert(story_.pixels.end(), frame_.begin(), frame_.end() - 1);
      }
    }
    in_frame_ = event == Event::kFrame;
    require(parser_.in_frame() == in_frame_, "in_frame() says whether a frame has begun");
  }

  const ScriptedStream& stream_;
  std::size_t piece_;
  FrameParser parser_;
  Story story_;
  std::vector<std::uint8_t> frame_;
  bool in_frame_ = false;
  bool taken_ = false;
};

}  // namespace

void fuzz_frame_parser(std::span<const std::uint8_t> input) {
  if (input.empty()) return;
  const ScriptedStream stream = stream_of(input.subspan(1));
  constexpr std::size_t kMostBytes = 1 << 20;
  if (stream.bytes.size() > kMostBytes) return;
  const Story whole = Reading(stream, stream.bytes.size() + 1).run();
  const Story divided = Reading(stream, 1 + input[0]).run();
  require(whole == divided, "it does not matter how the bytes of a transfer are divided");
}

}  // namespace fanlight::test
