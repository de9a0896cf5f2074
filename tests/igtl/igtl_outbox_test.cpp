// SPDX-License-Identifier: Apache-2.0
// What waits for an OpenIGTLink client, and what is lost.
#include "server/igtl/igtl_outbox.hpp"

#include <gtest/gtest.h>

namespace fanlight::test {
namespace igtl_outbox_tests {

IgtlMessage message(std::size_t bytes = 1) {
  return std::make_shared<const std::vector<std::uint8_t>>(bytes);
}

struct IgtlOutboxTest : testing::Test {
  ServerCounters counters;
  std::size_t bytes = 0;  // of all clients
  IgtlOutbox outbox{counters, bytes};

  bool offer(IgtlStream stream, const IgtlMessage& what, bool key = true) {
    return outbox.offer(stream, what, key);
  }
  std::uint64_t skipped() const { return counters.igtl_messages_skipped.value(); }
};

TEST_F(IgtlOutboxTest, KeepsTheNewestOfEachStream) {
  const auto newest = message();
  const auto camera = message();
  EXPECT_TRUE(offer(IgtlStream::kPicture, message()));
  EXPECT_TRUE(offer(IgtlStream::kPicture, newest));
  EXPECT_TRUE(offer(IgtlStream::kCamera, camera));
  EXPECT_EQ(outbox.next(), newest);
  EXPECT_EQ(outbox.next(), camera);
  EXPECT_EQ(outbox.next(), nullptr);
  EXPECT_EQ(counters.igtl_messages_offered.value(), 3U);
  EXPECT_EQ(skipped(), 1U);
}

TEST_F(IgtlOutboxTest, QueuesFrames) {
  const auto first = message();
  const auto second = message();
  offer(IgtlStream::kFrames, first);
  offer(IgtlStream::kFrames, second);
  EXPECT_EQ(bytes, 2U);
  EXPECT_EQ(outbox.next(), first);
  EXPECT_EQ(bytes, 2U) << "it is being sent";
  outbox.sent();
  EXPECT_EQ(bytes, 1U);
  EXPECT_EQ(outbox.next(), second);
  outbox.sent();
  EXPECT_EQ(bytes, 0U);
  EXPECT_EQ(skipped(), 0U);
}

TEST_F(IgtlOutboxTest, LosesFramesBeyondItsLimit) {
  EXPECT_TRUE(offer(IgtlStream::kFrames, message(IgtlOutbox::kMostFrameBytes)));
  EXPECT_FALSE(offer(IgtlStream::kFrames, message()));
  EXPECT_EQ(skipped(), 1U);
  outbox.clear();
  EXPECT_EQ(skipped(), 2U);
  EXPECT_EQ(bytes, 0U);
}

TEST_F(IgtlOutboxTest, LosesWhatIsBeyondTheLimitOfAll) {
  EXPECT_TRUE(offer(IgtlStream::kPicture, message(7)));
  bytes = IgtlOutbox::kMostBytesOfAll;  // of other clients, but for 7
  EXPECT_FALSE(offer(IgtlStream::kFrames, message()));
  EXPECT_FALSE(offer(IgtlStream::kVolume, message()));
  EXPECT_TRUE(offer(IgtlStream::kPicture, message(7))) << "in place of the one that waited";
  EXPECT_FALSE(offer(IgtlStream::kVideo, message()));
  EXPECT_TRUE(outbox.needs_key_picture());
  EXPECT_EQ(counters.igtl_messages_offered.value(), 5U);
  EXPECT_EQ(skipped(), 4U);
  outbox.clear();
  EXPECT_EQ(bytes, IgtlOutbox::kMostBytesOfAll - 7);
}

TEST_F(IgtlOutboxTest, BeginsAVideoWithAKeyPicture) {
  EXPECT_TRUE(outbox.needs_key_picture());
  EXPECT_FALSE(offer(IgtlStream::kVideo, message(), false));
  EXPECT_TRUE(offer(IgtlStream::kVideo, message(), true));
  EXPECT_FALSE(outbox.needs_key_picture());
  outbox.next();
  EXPECT_TRUE(offer(IgtlStream::kVideo, message(), false));
  EXPECT_EQ(skipped(), 1U);
}

TEST_F(IgtlOutboxTest, SendsNoPictureOfAVideoThatCannotBeDecoded) {
  const auto waits = message();
  const auto key = message();
  offer(IgtlStream::kVideo, waits, true);
  EXPECT_FALSE(offer(IgtlStream::kVideo, message(), false)) << "it would replace the one that it needs";
  EXPECT_TRUE(outbox.needs_key_picture());
  EXPECT_EQ(outbox.next(), waits);
  EXPECT_FALSE(offer(IgtlStream::kVideo, message(), false)) << "the one before it was lost";
  EXPECT_TRUE(offer(IgtlStream::kVideo, message(), true));
  EXPECT_TRUE(offer(IgtlStream::kVideo, key, true)) << "it needs none before it";
  EXPECT_EQ(outbox.next(), key);
  EXPECT_EQ(counters.igtl_messages_offered.value(), 5U);
  EXPECT_EQ(skipped(), 3U);
}

}  // namespace igtl_outbox_tests
}  // namespace fanlight::test
