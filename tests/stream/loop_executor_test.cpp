// SPDX-License-Identifier: Apache-2.0
#include "server/service/loop_executor.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <chrono>
#include <memory>
#include <thread>

namespace fanlight::test {
namespace {

TEST(LoopExecutor, DestroysWhatFollowsInTheLoop) {
  constexpr int kRounds = 5000;  // the encoder's thread is seldom the last to hold it
  boost::asio::io_context loop;
  auto stays = boost::asio::make_work_guard(loop);
  const std::thread::id here = std::this_thread::get_id();
  std::atomic<int> ended = 0;
  std::atomic<int> ended_elsewhere = 0;
  {
    LoopExecutor executor(loop);
    for (int round = 0; round < kRounds; ++round) {
      const std::shared_ptr<int> session(new int(round), [&](const int* each) {
        delete each;
        ++(std::this_thread::get_id() == here ? ended : ended_elsewhere);
      });
      executor.run(
          EncoderLane::kQuick, [] {}, [session] { EXPECT_TRUE(session); });
      // At once, so that the loop may be quicker than the encoder's thread.
      loop.run_one_for(std::chrono::seconds(10));
    }
  }
  EXPECT_EQ(ended, kRounds);
  EXPECT_EQ(ended_elsewhere, 0);
}

}  // namespace
}  // namespace fanlight::test
