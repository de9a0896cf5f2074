// SPDX-License-Identifier: Apache-2.0
// Tests of the hook: the calls that it catches on a hot thread, and those that it permits.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>

#include "proto/exchange/mailbox.hpp"
#include "renderer/parameters/cast_parameters.hpp"
#include "renderer/pipelines/pipelines.hpp"
#include "renderer/vulkan/gpu_memory.hpp"
#include "tests/hot_path/hot_threads.hpp"
#include "tests/hot_path/plain_gpu.hpp"

namespace fanlight::test {

// Has external linkage, so that its name appears in the stack.
void make_a_long_text();

namespace {

/// Prevents the compiler from removing an allocation.
void use(const void* memory) {
  asm volatile("" : : "r"(memory) : "memory");
}

void allocate() {
  const auto number = std::make_unique<int>(4);
  use(number.get());
}

void while_hot(const std::function<void()>& act) {
  const HotThread hot(gettid());
  act();
}

}  // namespace

void make_a_long_text() {
  use(std::string(100, 'x').data());
}

namespace {

class HookTest : public testing::Test {
 protected:
  // The driver has threads, so a death test must not run in a plain fork.
  void SetUp() override { GTEST_FLAG_SET(death_test_style, "threadsafe"); }

  static void expect_caught(const std::function<void()>& act, const std::string& call) {
    EXPECT_DEATH(while_hot(act), "hot path: " + call + " on the hot thread [0-9]+ .*, called from\n  .*");
  }
};
using HookDeathTest = HookTest;

TEST_F(HookDeathTest, CatchesAllocations) {
  expect_caught(allocate, "malloc");
  expect_caught([] { use(std::calloc(1, 4)); }, "calloc");
  expect_caught([] { use(std::aligned_alloc(64, 64)); }, "aligned_alloc");
  void* const memory = std::malloc(4);
  expect_caught([=] { use(std::realloc(memory, 8000)); }, "realloc");
  expect_caught([=] { std::free(memory); }, "free");
  std::free(memory);
}

TEST_F(HookDeathTest, CatchesWhatALibraryAllocatesForUs) {
  expect_caught([] { use(std::string(100, 'x').data()); }, "malloc");
  const std::string long_enough(600, 'x');
  expect_caught([&] { use(fmt::format("{}", long_enough).data()); }, "malloc");
}

TEST_F(HookDeathTest, SaysFromWhere) {
  EXPECT_DEATH(while_hot(make_a_long_text),
               "hot path: malloc on the hot thread [0-9]+ \\(\"hot_path.*\"\\), called from\n"
               "  operator new\\(unsigned long\\) .*\n"
               "  fanlight::test::make_a_long_text\\(\\) ");
}

TEST_F(HookDeathTest, CatchesLocks) {
  std::mutex mutex;
  expect_caught([&] { const std::lock_guard lock(mutex); }, "pthread_mutex_lock");
  expect_caught([&] { (void)mutex.try_lock(); }, "pthread_mutex_trylock");
  std::timed_mutex timed;
  expect_caught([&] { (void)timed.try_lock_for(std::chrono::seconds(1)); }, "pthread_mutex_clocklock");
  std::shared_mutex shared;
  expect_caught([&] { const std::shared_lock lock(shared); }, "pthread_rwlock_rdlock");
  expect_caught([&] { const std::lock_guard lock(shared); }, "pthread_rwlock_wrlock");
  std::unique_lock held(mutex);
  std::condition_variable condition;
  expect_caught([&] { condition.wait(held); }, "pthread_cond_wait");
}

TEST_F(HookDeathTest, CatchesLogLines) {
  expect_caught([] { std::printf("a line of %d\n", 2); }, "printf");
  expect_caught([] { std::fputs("a line\n", stderr); }, "fputs");
  expect_caught([] { std::cerr << "a line\n"; }, "fwrite");
  expect_caught([] { fmt::print("a line\n"); }, "fwrite");
  expect_caught([] { use(reinterpret_cast<void*>(write(STDERR_FILENO, "a line\n", 7))); }, "write");
  const auto logger = spdlog::stderr_color_mt("hot");
  expect_caught([&] { logger->info("a line"); }, "(pthread_mutex_lock|fwrite)");
}

TEST_F(HookDeathTest, CatchesWhatWeAskOfTheDriver) {
  const Gpu& gpu = plain_gpu();
  const auto take_memory = [&] {
    (void)GpuBuffer::create(gpu, "test", 64, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kDevice);
  };
  expect_caught(take_memory, "vkAllocateMemory");
  auto pipelines = Pipelines::create(gpu, {.sampling = Sampling::kGathering, .cache = {}});
  ASSERT_TRUE(pipelines);
  expect_caught([&] { (void)(*pipelines)->get(cast_keys({}, {}, Skipping::kOn).cast); },
                "vkCreateComputePipelines");
}

TEST_F(HookDeathTest, CatchesOurCodeWhereTheDriverCallsIt) {
  const Gpu& gpu = plain_gpu();
  const VkAllocationCallbacks ours{
      .pfnAllocation = [](void*, std::size_t bytes, std::size_t alignment,
                          VkSystemAllocationScope) { return std::aligned_alloc(alignment, bytes); },
      .pfnReallocation = [](void*, void* memory, std::size_t bytes, std::size_t,
                            VkSystemAllocationScope) { return std::realloc(memory, bytes); },
      .pfnFree = [](void*, void* memory) { std::free(memory); }};
  const VkFenceCreateInfo info{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence fence = VK_NULL_HANDLE;
  expect_caught([&] { vkCreateFence(gpu.device(), &info, &ours, &fence); }, "aligned_alloc");
}

TEST_F(HookTest, LetsTheDriverBe) {
  const Gpu& gpu = plain_gpu();
  const VkFenceCreateInfo info{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence fence = VK_NULL_HANDLE;
  const std::uint64_t before = calls_within_driver();
  while_hot([&] { vkCreateFence(gpu.device(), &info, nullptr, &fence); });
  EXPECT_GT(calls_within_driver(), before) << "the driver allocates a fence";
  vkDestroyFence(gpu.device(), fence, nullptr);
}

TEST_F(HookTest, LetsColdThreadsBe) {
  const HotThread other(getppid());
  allocate();
  std::mutex mutex;
  const std::lock_guard lock(mutex);
  fmt::print("a line\n");
}

TEST_F(HookTest, LetsAThreadBeThatIsColdAgain) {
  while_hot([] {});
  allocate();
}

TEST_F(HookTest, LetsBellsAndMailboxesBe) {
  Doorbell bell;
  Mailbox<int> mailbox(bell);
  while_hot([&] {
    mailbox.draft() = 4;
    mailbox.publish();
    bell.wait(-1);
    (void)mailbox.newest();
  });
}

}  // namespace
}  // namespace fanlight::test
