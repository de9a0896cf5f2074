// SPDX-License-Identifier: Apache-2.0
// InputBudget: what a client may send within a second.
#include "server/stream/input_budget.hpp"

#include <gtest/gtest.h>

namespace fanlight::test {
namespace {

TEST(InputBudget, AllowsALimitedNumberOfMessages) {
  InputBudget budget;
  int messages = 0;
  for (; budget.may_read(); ++messages) budget.begin_read();
  EXPECT_EQ(messages, InputBudget::kMessagesPerSecond);
  budget.refill();
  EXPECT_TRUE(budget.may_read());
}

TEST(InputBudget, AllowsALimitedNumberOfBytes) {
  InputBudget budget;
  budget.add_bytes(InputBudget::kBytesPerSecond - 1);
  EXPECT_TRUE(budget.may_read());
  budget.add_bytes(1'000'000);
  EXPECT_FALSE(budget.may_read()) << "a message may exceed the bytes that are left, and is the last";
  budget.refill();
  budget.add_bytes(InputBudget::kBytesPerSecond - 1);
  EXPECT_TRUE(budget.may_read()) << "the excess does not count for the next second";
}

TEST(InputBudget, AllowsALimitedNumberOfStreamChanges) {
  InputBudget budget;
  for (int change = 0; change < InputBudget::kStreamChangesPerSecond; ++change)
    EXPECT_TRUE(budget.take_stream_change());
  EXPECT_FALSE(budget.take_stream_change());
  EXPECT_FALSE(budget.take_stream_change());
  EXPECT_TRUE(budget.may_read()) << "messages are counted on their own";
  budget.refill();
  EXPECT_TRUE(budget.take_stream_change());
}

}  // namespace
}  // namespace fanlight::test
