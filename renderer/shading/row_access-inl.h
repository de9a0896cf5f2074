// SPDX-License-Identifier: Apache-2.0
// Reads and writes pixels that follow each other in a row, one a lane. Beyond the ends that the caller names,
// the pixel at the end is read again, and nothing is written.
#if defined(FANLIGHT_RENDERER_SHADING_ROW_ACCESS) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_SHADING_ROW_ACCESS
#undef FANLIGHT_RENDERER_SHADING_ROW_ACCESS
#else
#define FANLIGHT_RENDERER_SHADING_ROW_ACCESS
#endif

#include <algorithm>
#include <cstring>

#include "renderer/lanes/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

using namespace lanes::HWY_NAMESPACE;

constexpr int kRun = static_cast<int>(kLanes);

HWY_INLINE bool lies_between(int column, int first, int last) {
  return column >= first && column + kRun - 1 <= last;
}

// Of columns as floats.
HWY_INLINE Mask lies_within(Floats column, int first, int last) {
  return hn::And(hn::Ge(column, all(static_cast<float>(first))),
                 hn::Le(column, all(static_cast<float>(last))));
}

// `row`: its pixel 0. From `column` on, clamped to `first` .. `last`.
HWY_INLINE Floats read_row(const float* row, int column, int first, int last) {
  if (lies_between(column, first, last)) return hn::LoadU(kFloats, row + column);
  LaneFloats lanes;
  for (int lane = 0; lane < kRun; ++lane) lanes.lane[lane] = row[std::clamp(column + lane, first, last)];
  return loaded(lanes);
}

HWY_INLINE Words read_row(const std::uint32_t* row, int column, int first, int last) {
  if (lies_between(column, first, last)) return hn::LoadU(kWords, row + column);
  alignas(sizeof(std::uint32_t) * kMostLanes) std::uint32_t lanes[kMostLanes];
  for (int lane = 0; lane < kRun; ++lane) lanes[lane] = row[std::clamp(column + lane, first, last)];
  return hn::Load(kWords, lanes);
}

// Two words a pixel.
HWY_INLINE WordPairs read_pairs(const std::uint32_t* row, int column, int first, int last) {
  WordPairs words;
  if (lies_between(column, first, last)) {
    hn::LoadInterleaved2(kWords, row + 2 * column, words.first, words.second);
    return words;
  }
  std::uint32_t lanes[2 * kMostLanes];
  for (int lane = 0; lane < kRun; ++lane)
    std::memcpy(lanes + 2 * lane, row + 2 * std::clamp(column + lane, first, last), 2 * sizeof *row);
  hn::LoadInterleaved2(kWords, lanes, words.first, words.second);
  return words;
}

// The first `count` lanes.
HWY_INLINE void write_row(Words values, std::uint32_t* to, int count) {
  if (count >= kRun) return hn::StoreU(values, kWords, to);
  alignas(sizeof(std::uint32_t) * kMostLanes) std::uint32_t lanes[kMostLanes];
  hn::Store(values, kWords, lanes);
  std::memcpy(to, lanes, static_cast<std::size_t>(count) * sizeof *to);
}

HWY_INLINE void write_pairs(const WordPairs& values, std::uint32_t* to, int count) {
  if (count >= kRun) return hn::StoreInterleaved2(values.first, values.second, kWords, to);
  std::uint32_t lanes[2 * kMostLanes];
  hn::StoreInterleaved2(values.first, values.second, kWords, lanes);
  std::memcpy(to, lanes, 2 * static_cast<std::size_t>(count) * sizeof *to);
}

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
