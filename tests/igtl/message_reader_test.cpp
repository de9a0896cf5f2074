// SPDX-License-Identifier: Apache-2.0
// The reader of a stream of messages: slow bytes, lengths that lie, damaged streams.
#include "proto/igtl/message_reader.hpp"

#include <gtest/gtest.h>

#include <random>

#include "proto/base/crc64.hpp"
#include "proto/igtl/opened_message.hpp"
#include "proto/igtl/text_bodies.hpp"
#include "tests/igtl/corpus.hpp"
#include "tests/igtl/sent_messages.hpp"

namespace fanlight::test {
namespace message_reader_tests {

using Event = igtl::MessageReader::Event;

struct Seen {
  std::vector<Event> events;  // but kMore
  std::vector<Bytes> bodies;
};

/// Gives the reader a stream in pieces of up to `most` bytes, until it is lost.
Seen read(igtl::MessageReader& reader, std::span<const std::uint8_t> stream, std::size_t most) {
  Seen seen;
  while (!stream.empty()) {
    const auto room = reader.room();
    EXPECT_FALSE(room.empty());
    const std::size_t bytes = std::min({room.size(), stream.size(), most});
    std::copy_n(stream.begin(), bytes, room.begin());
    stream = stream.subspan(bytes);
    const Event event = reader.filled(bytes);
    if (event == Event::kMore) continue;
    seen.events.push_back(event);
    if (event == Event::kMessage) seen.bodies.emplace_back(reader.body().begin(), reader.body().end());
    if (event == Event::kLost || event == Event::kUnwanted) break;
  }
  return seen;
}

Bytes both(Bytes one, const Bytes& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

Bytes query(const char* type) {
  igtl::MessageWriter writer;
  writer.begin({.type = type});
  const auto message = writer.finish();
  return {message.begin(), message.end()};
}

TEST(MessageReader, FindsMessagesInPiecesOfAnySize) {
  const Bytes stream =
      both(both(message_of(SentImage{}), query("GET_STATUS")), message_of(SentImage{.grey = 7}));
  for (const std::size_t most : {1UL, 7UL, 57UL, 58UL, 59UL, 100'000UL}) {
    igtl::MessageReader reader(1 << 20, 1 << 20);
    const Seen seen = read(reader, stream, most);
    EXPECT_EQ(seen.events, (std::vector{Event::kMessage, Event::kMessage, Event::kMessage})) << most;
    ASSERT_EQ(seen.bodies.size(), 3U);
    EXPECT_TRUE(seen.bodies[1].empty());
    EXPECT_EQ(seen.bodies[2].back(), 7);
  }
}

TEST(MessageReader, SkipsWhatIsTooLongAndGoesOn) {
  igtl::MessageReader reader(100, 1 << 20);
  const Bytes stream = both(message_of(SentImage{.columns = 900, .rows = 700}), query("GET_STATUS"));
  EXPECT_EQ(read(reader, stream, 10'000).events, (std::vector{Event::kSkipped, Event::kMessage}));
}

TEST(MessageReader, RefusesALengthThatNothingHas) {
  Bytes message = query("IMAGE");
  message[43] = 1;  // 2^48 bytes
  igtl::MessageReader reader(1 << 20, 1 << 20);
  EXPECT_EQ(read(reader, message, 58).events, std::vector{Event::kUnwanted});
}

TEST(MessageReader, SaysWhereItLostThePlaceAndRestarts) {
  igtl::MessageReader reader(1 << 20, 1 << 20);
  EXPECT_EQ(read(reader, both(query("GET_STATUS"), Bytes(58, 0x41)), 58).events,
            (std::vector{Event::kMessage, Event::kLost}));
  reader.restart();
  EXPECT_EQ(read(reader, query("GET_STATUS"), 58).events, std::vector{Event::kMessage});
}

TEST(MessageReader, GivesItsMemoryAway) {
  igtl::MessageReader reader(1 << 20, 1 << 20);
  const Bytes first = message_of(SentImage{.grey = 1});
  (void)read(reader, first, 100'000);
  const auto body = reader.body();
  Bytes taken;
  reader.swap_body(taken);
  EXPECT_EQ(taken.data(), body.data());
  (void)read(reader, message_of(SentImage{.grey = 2}), 100'000);
  EXPECT_EQ(taken[igtl::kImageHeaderBytes], 1) << "the next message is elsewhere";
}

// Whatever the bytes are, the reader and the parsers end, and read nothing beyond them (the address sanitizer
// looks on).
TEST(MessageReader, Stands100000MutatedMessages) {
  std::vector<Bytes> originals = corpus_messages();
  igtl::MessageWriter writer;
  writer.begin({.type = "TDATA"}).resize(igtl::kHeadBytes + 3 * igtl::kToolBytes);
  const auto tools = writer.finish();
  originals.emplace_back(tools.begin(), tools.end());
  std::mt19937 random(21);
  igtl::MessageReader reader(1 << 16, 1 << 20);
  std::size_t read_whole = 0;
  for (int i = 0; i < 100'000; ++i) {
    Bytes message = originals[random() % originals.size()];
    for (std::uint32_t changes = 1 + random() % 4; changes > 0; --changes)
      message[random() % message.size()] = static_cast<std::uint8_t>(random());
    if (random() % 4 == 0) message.resize(random() % message.size());
    reader.restart();
    for (const Bytes& body : read(reader, message, 1 + random() % 4000).bodies) {
      ++read_whole;
      // Half of them with a checksum that fits, so that the content is looked at.
      igtl::MessageHead head = reader.head();
      if (random() % 2 == 0) head.crc = crc64(body);
      const auto opened = igtl::open_message(head, body);
      if (opened.state != igtl::OpenedMessage::State::kGood) continue;
      std::size_t texts = 0;
      opened.metadata.for_each(
          [&](std::string_view name, std::string_view value) { texts += name.size() + value.size(); });
      EXPECT_LE(texts, body.size());
      (void)igtl::parse_image(opened.content);
      (void)igtl::parse_transform(opened.content);
      (void)igtl::parse_status(opened.content);
      (void)igtl::parse_string(opened.content);
      (void)igtl::parse_command(opened.content);
      (void)igtl::parse_capability(opened.content);
      for (std::size_t tool = 0; tool < igtl::tool_count(opened.content); ++tool)
        (void)igtl::parse_tool(opened.content, tool);
    }
  }
  EXPECT_GT(read_whole, 10'000U);
}

}  // namespace message_reader_tests
}  // namespace fanlight::test
