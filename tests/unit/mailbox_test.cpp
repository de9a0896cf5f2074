// SPDX-License-Identifier: Apache-2.0
#include "proto/exchange/mailbox.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace fanlight {
namespace {

TEST(Mailbox, IsEmptyUntilTheFirstPublish) {
  Doorbell bell;
  Mailbox<int> mailbox(bell);
  EXPECT_EQ(mailbox.newest(), nullptr);
  mailbox.draft() = 7;
  EXPECT_EQ(mailbox.newest(), nullptr);
  EXPECT_FALSE(bell.wait(0));
}

TEST(Mailbox, GivesEachValueOnceAndRingsTheBell) {
  Doorbell bell;
  Mailbox<int> mailbox(bell);
  mailbox.draft() = 7;
  EXPECT_FALSE(mailbox.publish());
  EXPECT_TRUE(bell.wait(0));
  ASSERT_NE(mailbox.newest(), nullptr);
  EXPECT_EQ(mailbox.newest(), nullptr) << "the same value twice";
}

TEST(Mailbox, ReplacesWhatWasNeverRead) {
  Doorbell bell;
  Mailbox<int> mailbox(bell);
  mailbox.draft() = 1;
  EXPECT_FALSE(mailbox.publish());
  mailbox.draft() = 2;
  EXPECT_TRUE(mailbox.publish());
  const int* const newest = mailbox.newest();
  ASSERT_NE(newest, nullptr);
  EXPECT_EQ(*newest, 2);
}

TEST(Mailbox, AValueStaysWhileTheWriterGoesOn) {
  Doorbell bell;
  Mailbox<int> mailbox(bell);
  mailbox.draft() = 1;
  mailbox.publish();
  const int* const held = mailbox.newest();
  ASSERT_NE(held, nullptr);
  for (int value = 2; value < 10; ++value) {
    mailbox.draft() = value;
    mailbox.publish();
    EXPECT_EQ(*held, 1);
  }
}

TEST(Mailbox, KeepsTheMemoryOfItsValues) {
  Doorbell bell;
  Mailbox<std::vector<int>> mailbox(bell, std::vector<int>(100));
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(mailbox.draft().size(), 100U);
    mailbox.publish();
    mailbox.newest();
  }
}

// Run with the thread sanitizer: access to a slot from both sides would be a data race.
TEST(Mailbox, TwoThreadsNeverSeeATornOrAnOlderValue) {
  struct Twice {
    std::uint64_t first = 0;
    std::uint64_t second = 0;
  };
  constexpr std::uint64_t kValues = 100'000;
  Doorbell bell;
  Mailbox<Twice> mailbox(bell);
  std::uint64_t replaced = 0;
  std::jthread writer([&] {
    for (std::uint64_t value = 1; value <= kValues; ++value) {
      mailbox.draft() = {value, value};
      if (mailbox.publish()) ++replaced;
    }
  });
  std::uint64_t read = 0;
  std::uint64_t last = 0;
  while (last < kValues) {
    bell.wait(-1);
    const Twice* const newest = mailbox.newest();
    if (newest == nullptr) continue;
    ASSERT_EQ(newest->first, newest->second);
    ASSERT_GT(newest->first, last);
    last = newest->first;
    ++read;
  }
  writer.join();
  EXPECT_EQ(read + replaced, kValues);
}

}  // namespace
}  // namespace fanlight
