// SPDX-License-Identifier: Apache-2.0
#include "server/bench/machine_limits.hpp"

// Highway includes this file once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/bench/machine_limits.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "proto/base/clock.hpp"

HWY_BEFORE_NAMESPACE();
namespace fanlight::machine_limits::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::ScalableTag<float> kFloats;
constexpr hn::ScalableTag<std::uint32_t> kWords;
constexpr hn::ScalableTag<std::int32_t> kIndices;

/// The sum of all words.
std::uint32_t read_words(const std::uint32_t* words, std::size_t count) {
  auto low = hn::Zero(kWords);
  auto high = hn::Zero(kWords);
  const std::size_t lanes = hn::Lanes(kWords);
  for (std::size_t at = 0; at + 2 * lanes <= count; at += 2 * lanes) {
    low = hn::Add(low, hn::LoadU(kWords, words + at));
    high = hn::Add(high, hn::LoadU(kWords, words + at + lanes));
  }
  return hn::GetLane(hn::Add(low, high));
}

/// Gathers the words at all indices; returns a sum of some.
std::uint32_t gather_words(const std::uint32_t* words, const std::int32_t* indices, std::size_t count) {
  auto sum = hn::Zero(kWords);
  for (std::size_t at = 0; at < count; at += hn::Lanes(kWords))
    sum = hn::Add(sum, hn::GatherIndex(kWords, words, hn::LoadU(kIndices, indices + at)));
  return hn::GetLane(sum);
}

/// Multiplies and adds eight chains of vectors; returns the number of operations.
double multiply_and_add(std::size_t rounds, float& result) {
  auto a = hn::Set(kFloats, 0.5F);
  auto b = a, c = a, d = a, e = a, f = a, g = a, h = a;
  const auto factor = hn::Set(kFloats, 0.5F);
  for (std::size_t round = 0; round < rounds; ++round) {
    a = hn::MulAdd(a, factor, factor);
    b = hn::MulAdd(b, factor, factor);
    c = hn::MulAdd(c, factor, factor);
    d = hn::MulAdd(d, factor, factor);
    e = hn::MulAdd(e, factor, factor);
    f = hn::MulAdd(f, factor, factor);
    g = hn::MulAdd(g, factor, factor);
    h = hn::MulAdd(h, factor, factor);
  }
  result = hn::GetLane(hn::Add(hn::Add(hn::Add(a, b), hn::Add(c, d)), hn::Add(hn::Add(e, f), hn::Add(g, h))));
  constexpr std::size_t kChains = 8;
  constexpr std::size_t kOperations = 2;
  return static_cast<double>(rounds * kChains * kOperations * hn::Lanes(kFloats));
}

std::size_t word_lanes() {
  return hn::Lanes(kWords);
}

const char* name() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace fanlight::machine_limits::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fanlight {

namespace machine_limits {

HWY_EXPORT(read_words);
HWY_EXPORT(gather_words);
HWY_EXPORT(multiply_and_add);
HWY_EXPORT(word_lanes);
HWY_EXPORT(name);

namespace {

/// Seconds that `work` takes on all processors at once, each in a thread: the least of several runs.
double least_s(std::size_t processors, const std::function<void(std::size_t)>& work) {
  constexpr int kRuns = 7;
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) {
    const std::int64_t from_ns = now_ns();
    {
      std::vector<std::jthread> threads;
      for (std::size_t thread = 0; thread < processors; ++thread) threads.emplace_back(work, thread);
    }
    least = std::min(least, static_cast<double>(now_ns() - from_ns) / 1e9);
  }
  return least;
}

/// Makes the compiler compute a value that is not used.
template <typename Value>
void compute(const Value& value) {
  asm volatile("" : : "m"(value) : "memory");
}

double measured_gigahertz() {
  constexpr std::uint64_t kRounds = 50'000'000;
  constexpr double kCycles = 3;  // of a 64 bit multiplication, on x86-64 since 2008 and on most of ARM
  const double s = least_s(1, [](std::size_t) {
    std::uint64_t product = 3;
    std::uint64_t factor = 5;
    for (std::uint64_t round = 0; round < kRounds; ++round) {
      product *= factor;
      asm volatile("" : "+r"(product), "+r"(factor));  // or the compiler would find a shorter way
    }
    compute(product);
  });
  return kRounds * kCycles / s / 1e9;
}

double measured_read_gb_s(std::size_t processors) {
  // More than the caches of any processor so far. Each thread writes its part first, so that the part lies
  // near it.
  constexpr std::size_t kAllWords = std::size_t{1} << 28;
  const std::size_t words_of_each = kAllWords / processors;
  std::vector<std::unique_ptr<std::uint32_t[]>> parts(processors);
  least_s(processors, [&](std::size_t thread) {
    if (!parts[thread]) parts[thread] = std::make_unique<std::uint32_t[]>(words_of_each);
  });
  const double s = least_s(processors, [&](std::size_t thread) {
    compute(HWY_DYNAMIC_DISPATCH(read_words)(parts[thread].get(), words_of_each));
  });
  return static_cast<double>(words_of_each * processors * sizeof(std::uint32_t)) / s / 1e9;
}

/// ns a word and processor. `bytes`: in which the words lie; `together`: that follow one another.
double measured_gather_ns(std::size_t processors, std::size_t bytes, std::size_t together) {
  constexpr std::size_t kIndices = 1 << 16;
  constexpr int kRounds = 100;
  const std::vector<std::uint32_t> words(bytes / sizeof(std::uint32_t), 1);
  std::mt19937 random(1);
  std::vector<std::int32_t> indices(kIndices);
  for (std::size_t at = 0; at < kIndices; ++at) {
    const bool follows = at % together != 0;
    indices[at] =
        follows ? indices[at - 1] + 1 : static_cast<std::int32_t>(random() % (words.size() - together));
  }
  const double s = least_s(processors, [&](std::size_t) {
    for (int round = 0; round < kRounds; ++round)
      compute(HWY_DYNAMIC_DISPATCH(gather_words)(words.data(), indices.data(), indices.size()));
  });
  return 1e9 * s / (static_cast<double>(kIndices) * kRounds);
}

double measured_gflop_s(std::size_t processors) {
  constexpr std::size_t kRounds = 20'000'000;
  double operations = 0;
  const double s = least_s(processors, [&](std::size_t thread) {
    float result = 0;
    const double done = HWY_DYNAMIC_DISPATCH(multiply_and_add)(kRounds, result);
    if (thread == 0) operations = done;
    compute(result);
  });
  return operations * static_cast<double>(processors) / s / 1e9;
}

/// The processor's name of Highway's target.
std::string vectors(std::string_view target) {
  if (target.starts_with("AVX3")) return "AVX-512";
  return std::string(target);
}

}  // namespace

}  // namespace machine_limits

MachineLimits measure_machine_limits() {
  using namespace machine_limits;
  constexpr std::size_t kNearBytes = std::size_t{32} << 10;
  constexpr std::size_t kFarBytes = std::size_t{16} << 20;
  const std::size_t processors = std::max(std::thread::hardware_concurrency(), 1U);
  return {.processors = processors,
          .vectors = vectors(HWY_DYNAMIC_DISPATCH(name)()),
          .gigahertz = measured_gigahertz(),
          .read_gb_s = measured_read_gb_s(processors),
          .gather_ns = measured_gather_ns(processors, kNearBytes, HWY_DYNAMIC_DISPATCH(word_lanes)()),
          .far_gather_ns = measured_gather_ns(processors, kFarBytes, 1),
          .gflop_s = measured_gflop_s(processors)};
}

}  // namespace fanlight
#endif
