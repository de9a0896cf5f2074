// SPDX-License-Identifier: Apache-2.0
// What `fanlight bench` computes from its measurements. Uses no GPU.
#include <gtest/gtest.h>

#include <vector>

#include "server/bench/scale.hpp"
#include "server/bench/trace_picture.hpp"

namespace fanlight::test::bench_figures_tests {
namespace {

TEST(ScaleExponentTest, IsThePowerByWhichCostsGrow) {
  EXPECT_NEAR(scale_exponent({1, 2, 4}, {3, 6, 12}), 1, 1e-9);
  EXPECT_NEAR(scale_exponent({1, 2, 4}, {3, 12, 48}), 2, 1e-9);
  EXPECT_NEAR(scale_exponent({1, 2, 4}, {5, 5, 5}), 0, 1e-9);
}

TEST(ScaleExponentTest, IsZeroWhereThereIsNone) {
  EXPECT_EQ(scale_exponent({1, 2}, {0, 5}), 0);
  EXPECT_EQ(scale_exponent({1}, {5}), 0);
  EXPECT_EQ(scale_exponent({}, {}), 0);
}

StageSpan span_ms(double begin, double end) {
  return {.begin_ns = static_cast<std::int64_t>(begin * 1e6), .end_ns = static_cast<std::int64_t>(end * 1e6)};
}

TEST(TracePictureTest, HasABarForEachStageAndEncoding) {
  BlockTrace block;
  VolumeTrace volume{.volume_id = 7, .load = {}, .stages = {}, .finished_ns = 30'000'000};
  volume.stages[static_cast<std::size_t>(Stage::kCast)] = span_ms(1, 20);
  volume.stages[static_cast<std::size_t>(Stage::kReadBack)] = span_ms(29, 30);
  block.volumes.push_back(volume);
  block.encodings.push_back({.volume_id = 7, .span = span_ms(31, 40)});
  const std::string picture = trace_picture(block);
  EXPECT_NE(picture.find("volume 7, cast, 19.00 ms"), std::string::npos);
  EXPECT_NE(picture.find("volume 7, read_back, 1.00 ms"), std::string::npos);
  EXPECT_NE(picture.find("volume 7, 9.00 ms"), std::string::npos);
  EXPECT_NE(picture.find("passes 2 and 3"), std::string::npos);
}

TEST(TracePictureTest, IsEmptyWithoutVolumes) {
  EXPECT_EQ(trace_picture({}), "");
}

}  // namespace
}  // namespace fanlight::test::bench_figures_tests
