// SPDX-License-Identifier: Apache-2.0
#include "renderer/volume/render_workers.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <barrier>
#include <csignal>
#include <vector>

namespace fanlight::test::render_workers_tests {
namespace {

TEST(RenderWorkersTest, CallEachIndexOnce) {
  RenderWorkers workers(3);
  EXPECT_EQ(workers.threads(), 3U);
  for (const std::size_t count : {0U, 1U, 2U, 3U, 100U, 7U}) {
    std::vector<std::atomic<int>> calls(count);
    workers.run(count, [&](std::size_t, std::size_t index) { ++calls[index]; });
    EXPECT_TRUE(std::ranges::all_of(calls, [](const auto& each) { return each == 1; })) << count;
  }
}

TEST(RenderWorkersTest, WorkAtTheSameTimeAsThreadsOfTheirOwn) {
  RenderWorkers workers(3);
  for (int round = 0; round < 20; ++round) {
    std::barrier together(3);  // none goes on before all three are there
    std::array<std::atomic<int>, 3> calls{};
    workers.run(3, [&](std::size_t thread, std::size_t) {
      ++calls[thread];
      together.arrive_and_wait();
    });
    for (const auto& each : calls) EXPECT_EQ(each, 1);
  }
}

TEST(RenderWorkersTest, ASignalIsNoWork) {
  struct sigaction quiet {};
  quiet.sa_handler = [](int) {};
  struct sigaction before {};
  ASSERT_EQ(sigaction(SIGUSR2, &quiet, &before), 0);
  {
    RenderWorkers workers(3);
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGUSR2);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // of this thread: a worker gets it
    std::atomic<int> calls = 0;
    for (int round = 0; round < 200; ++round) {
      kill(getpid(), SIGUSR2);
      workers.run(5, [&](std::size_t, std::size_t) { ++calls; });
    }
    EXPECT_EQ(calls, 1000);
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  }
  sigaction(SIGUSR2, &before, nullptr);
}

TEST(RenderWorkersTest, OneThreadIsTheCaller) {
  RenderWorkers workers(1);
  int calls = 0;
  workers.run(5, [&](std::size_t thread, std::size_t) { calls += thread == 0 ? 1 : 0; });
  EXPECT_EQ(calls, 5);
}

TEST(RenderWorkersTest, WhatTheyWroteIsThereAtTheReturn) {
  RenderWorkers workers(4);
  std::vector<int> written(50);  // not atomic: the thread sanitizer looks at it
  for (int round = 1; round <= 200; ++round) {
    workers.run(written.size(), [&](std::size_t, std::size_t index) { written[index] += 1; });
    ASSERT_TRUE(std::ranges::all_of(written, [&](int each) { return each == round; })) << round;
  }
}

}  // namespace
}  // namespace fanlight::test::render_workers_tests
