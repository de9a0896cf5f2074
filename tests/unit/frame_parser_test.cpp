// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/frame_parser.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace fanlight {
namespace {

using Event = FrameParser::Event;
using Bytes = std::vector<std::uint8_t>;

Bytes frame(std::uint64_t sequence, std::uint32_t pixels = 200) {
  const Bytes payload(pixels, static_cast<std::uint8_t>(sequence));
  const auto header =
      probe::encode({.sequence = sequence, .payload_bytes = pixels, .payload_crc32c = crc32c(payload)});
  Bytes bytes(header.size() + pixels, static_cast<std::uint8_t>(sequence));
  std::ranges::copy(header, bytes.begin());
  return bytes;
}

Bytes operator+(Bytes first, const Bytes& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

Bytes front(Bytes bytes, std::size_t count) {
  bytes.resize(count);
  return bytes;
}

struct FrameParserTest : testing::Test {
  /// Events of one transfer, without the final kMore.
  std::vector<Event> transfer(const Bytes& bytes) {
    parser.begin_transfer();
    std::vector<Event> events;
    for (std::span<const std::uint8_t> left = bytes;;) {
      const Event event = parser.next(left);
      if (event == Event::kMore) return events;
      events.push_back(event);
      if (event == Event::kFrame) {
        sequences.push_back(parser.header().sequence);
        pixels.assign(parser.header().payload_bytes, 0);
        parser.take_pixels(pixels);
      }
    }
  }

  FrameParser parser;
  std::vector<std::uint64_t> sequences;
  Bytes pixels;
};

TEST_F(FrameParserTest, FramesComeWhole) {
  EXPECT_EQ(transfer(frame(3)), (std::vector{Event::kFrame, Event::kWhole}));
  EXPECT_EQ(pixels, Bytes(200, 3));
  EXPECT_EQ(transfer(frame(4) + frame(5)),
            (std::vector{Event::kFrame, Event::kWhole, Event::kFrame, Event::kWhole}));
  EXPECT_EQ(sequences, (std::vector<std::uint64_t>{3, 4, 5}));
  EXPECT_EQ(parser.bytes_skipped(), 0U);
}

TEST_F(FrameParserTest, AFrameMaySpanTransfers) {
  const Bytes whole = frame(3);
  EXPECT_EQ(transfer(front(whole, 100)), (std::vector{Event::kFrame}));
  EXPECT_TRUE(parser.in_frame());
  EXPECT_EQ(transfer(Bytes(whole.begin() + 100, whole.end())), (std::vector{Event::kWhole}));
  EXPECT_EQ(pixels, Bytes(200, 3));
}

TEST_F(FrameParserTest, WhoLandsInTheMiddleFindsTheNextFrame) {
  const Bytes whole = frame(1);
  const Bytes tail(whole.begin() + 30, whole.end());
  EXPECT_EQ(transfer(tail + frame(2)), (std::vector{Event::kFrame, Event::kWhole}));
  EXPECT_EQ(parser.bytes_skipped(), tail.size());
}

TEST_F(FrameParserTest, AWrongChecksumDamagesThatFrameAlone) {
  Bytes damaged = frame(1);
  damaged[100] ^= 1;
  EXPECT_EQ(transfer(damaged + frame(2)),
            (std::vector{Event::kFrame, Event::kDamaged, Event::kFrame, Event::kWhole}));
}

TEST_F(FrameParserTest, ACutFrameCostsNoOtherWhereTransfersEnd) {
  EXPECT_EQ(transfer(front(frame(1), 150)), (std::vector{Event::kFrame}));
  EXPECT_EQ(transfer(frame(2)), (std::vector{Event::kCut, Event::kFrame, Event::kWhole}));
  EXPECT_EQ(sequences, (std::vector<std::uint64_t>{1, 2}));
  EXPECT_EQ(parser.bytes_skipped(), 0U);
}

// The cut frame takes its missing 114 bytes from the next one, whose rest is noise.
TEST_F(FrameParserTest, WithoutEndsOfTransfersItCostsTheNext) {
  EXPECT_EQ(transfer(front(frame(1), 150) + frame(2) + frame(3)),
            (std::vector{Event::kFrame, Event::kDamaged, Event::kFrame, Event::kWhole}));
  EXPECT_EQ(sequences, (std::vector<std::uint64_t>{1, 3}));
  EXPECT_EQ(parser.bytes_skipped(), 150U);
}

TEST_F(FrameParserTest, NoiseBetweenFramesIsSkippedAndCounted) {
  Bytes noise(77, 'F');
  EXPECT_EQ(transfer(noise + frame(1) + noise + frame(2)),
            (std::vector{Event::kFrame, Event::kWhole, Event::kFrame, Event::kWhole}));
  EXPECT_EQ(parser.bytes_skipped(), 2 * 77U);
}

TEST_F(FrameParserTest, PixelsThatLookLikeAHeaderArePixels) {
  const Bytes inner = frame(9, 40);
  const auto header = probe::encode({.sequence = 1,
                                     .payload_bytes = static_cast<std::uint32_t>(inner.size()),
                                     .payload_crc32c = crc32c(inner)});
  EXPECT_EQ(transfer(Bytes(header.begin(), header.end()) + inner),
            (std::vector{Event::kFrame, Event::kWhole}));
  EXPECT_EQ(pixels, inner);
}

TEST_F(FrameParserTest, AHeaderMayBeDividedAnywhere) {
  const Bytes whole = frame(5);
  for (std::size_t cut = 1; cut < probe::kFrameHeaderBytes; ++cut) {
    transfer(Bytes{0, 'F', 'L'} + front(whole, cut));
    EXPECT_EQ(transfer(Bytes(whole.begin() + static_cast<std::ptrdiff_t>(cut), whole.end())),
              (std::vector{Event::kFrame, Event::kWhole}));
  }
  EXPECT_EQ(parser.bytes_skipped(), 3 * (probe::kFrameHeaderBytes - 1));
}

// Eight bytes that look like a header of 200 bytes delay a whole frame behind them.
TEST_F(FrameParserTest, AFrameBehindAFalseBeginningIsFound) {
  const Bytes false_beginning = {'F', 'L', 'P', 'F', 0, 1, 200, 0};
  for (const std::uint32_t size : {0U, 10U, 60U, 100U, 1000U}) {
    sequences.clear();
    const Bytes stream = false_beginning + frame(1, size) + frame(2, size);
    for (std::size_t cut = 1; cut < stream.size(); ++cut) {
      sequences.clear();
      parser = {};
      auto events = transfer(front(stream, cut));
      // A separate allocation, so that the sanitizer sees reads beyond its bounds.
      const Bytes rest(stream.begin() + static_cast<std::ptrdiff_t>(cut), stream.end());
      for (std::span<const std::uint8_t> left = rest;;) {
        const Event event = parser.next(left);
        if (event == Event::kMore) break;
        events.push_back(event);
        if (event == Event::kFrame) sequences.push_back(parser.header().sequence);
      }
      transfer(Bytes(300, 0));  // decides whether the pending bytes were a header
      EXPECT_EQ(sequences, (std::vector<std::uint64_t>{1, 2})) << size << " pixels, cut at " << cut;
      EXPECT_EQ(std::ranges::count(events, Event::kDamaged), 0);
    }
  }
}

TEST_F(FrameParserTest, AFrameWithoutPixelsIsWhole) {
  EXPECT_EQ(transfer(frame(1, 0)), (std::vector{Event::kFrame, Event::kWhole}));
}

TEST_F(FrameParserTest, AResetCutsWhatIsUnderWay) {
  EXPECT_FALSE(parser.reset());
  transfer(front(frame(1), 150));
  EXPECT_TRUE(parser.reset());
  EXPECT_FALSE(parser.in_frame());
  EXPECT_EQ(transfer(frame(2)), (std::vector{Event::kFrame, Event::kWhole}));
}

}  // namespace
}  // namespace fanlight
