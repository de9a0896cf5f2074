// SPDX-License-Identifier: Apache-2.0
// The check that one thread uses an object: in builds that have it, and that others do not pay for it.
#include <gtest/gtest.h>

#include <thread>
#include <type_traits>

#include "proto/base/thread_owner.hpp"

namespace fanlight::test {
namespace {

#ifdef FANLIGHT_CHECK_THREADS

TEST(ThreadOwnerTest, EndsTheProcessOnASecondThread) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const ThreadOwner owner;
  owner.check();
  EXPECT_DEATH(std::thread([&] { owner.check(); }).join(), "used by two threads");
}

TEST(ThreadOwnerTest, BelongsToTheFirstThreadThatCalls) {
  const ThreadOwner owner;
  std::thread([&] {
    owner.check();
    owner.check();
  }).join();
}

TEST(ThreadOwnerTest, CanBePassedOn) {
  ThreadOwner owner;
  owner.check();
  owner.release();
  std::thread([&] { owner.check(); }).join();
  const ThreadOwner moved = std::move(owner);
  moved.check();
}

#else

TEST(ThreadOwnerTest, IsEmptyWithoutTheCheck) {
  EXPECT_TRUE(std::is_empty_v<ThreadOwner>);
  const ThreadOwner owner;
  owner.check();
  std::thread([&] { owner.check(); }).join();
}

#endif

}  // namespace
}  // namespace fanlight::test
