// SPDX-License-Identifier: Apache-2.0
// Vectors of numbers: a lane is a ray or a pixel. Included once for each instruction set, by the files that
// Highway compiles several times.
#if defined(FANLIGHT_RENDERER_LANES_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_LANES_LANES
#undef FANLIGHT_RENDERER_LANES_LANES
#else
#define FANLIGHT_RENDERER_LANES_LANES
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "shaders/vector_types.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::lanes::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A block of 4 x 4 rays at most: a tile has 8 x 8.
constexpr std::size_t kMostLanes = 16;
constexpr hn::CappedTag<float, kMostLanes> kFloats;
constexpr hn::RebindToSigned<decltype(kFloats)> kIntegers;
constexpr hn::RebindToUnsigned<decltype(kFloats)> kWords;
#if HWY_TARGET != HWY_SCALAR
constexpr hn::Repartition<std::uint64_t, decltype(kFloats)> kPairs;
constexpr hn::Repartition<std::int64_t, decltype(kFloats)> kPairOffsets;
#endif
constexpr std::size_t kLanes = hn::MaxLanes(kFloats);

using Floats = hn::Vec<decltype(kFloats)>;
using Integers = hn::Vec<decltype(kIntegers)>;
using Words = hn::Vec<decltype(kWords)>;
using Mask = hn::Mask<decltype(kFloats)>;

// The lanes of a vector in memory.
struct LaneFloats {
  alignas(sizeof(float) * kMostLanes) float lane[kMostLanes];
};

HWY_INLINE Floats all(float value) {
  return hn::Set(kFloats, value);
}
HWY_INLINE Floats zero() {
  return hn::Zero(kFloats);
}
HWY_INLINE Mask none() {
  return hn::Lt(zero(), zero());
}
HWY_INLINE bool is_empty(Mask mask) {
  return hn::AllFalse(kFloats, mask);
}
HWY_INLINE Floats negative(Floats value) {
  return hn::Neg(value);
}
HWY_INLINE Floats where(Mask mask, Floats yes, Floats no) {
  return hn::IfThenElse(mask, yes, no);
}
HWY_INLINE Mask where(Mask mask, Mask yes, Mask no) {
  return hn::Or(hn::And(mask, yes), hn::AndNot(mask, no));
}
HWY_INLINE Floats clamped(Floats value, Floats least, Floats most) {
  return hn::Min(hn::Max(value, least), most);
}
// As GLSL's mix() on lavapipe.
HWY_INLINE Floats mixed(Floats from, Floats to, Floats share) {
  return from + share * (to - from);
}
HWY_INLINE LaneFloats stored(Floats value) {
  LaneFloats lanes;
  hn::Store(value, kFloats, lanes.lane);
  return lanes;
}
HWY_INLINE Floats loaded(const LaneFloats& lanes) {
  return hn::Load(kFloats, lanes.lane);
}
// The lanes of a mask as bits, the first lane in the lowest one.
HWY_INLINE std::uint32_t bits_of(Mask mask) {
  alignas(8) std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(kFloats, mask, bytes);
  return static_cast<std::uint32_t>(bytes[0]) | static_cast<std::uint32_t>(bytes[1]) << 8U;
}

// Of whole values from 0 to 2^23 - 1. After the sum their bits are the mantissa (whole_number.h): a
// conversion that knows no range takes three more steps.
HWY_INLINE Integers whole(Floats value) {
  const Words bits = hn::BitCast(kWords, value + all(8388608.0F));
  return hn::BitCast(kIntegers, bits - hn::Set(kWords, 0x4B000000U));
}

// A point, a direction or a colour.
struct Point {
  Floats x;
  Floats y;
  Floats z;
};
HWY_INLINE Point all(const shaders::vec3& value) {
  return {all(value.x), all(value.y), all(value.z)};
}
HWY_INLINE Point at(const Point& from, Floats t, const Point& forward) {
  return {from.x + t * forward.x, from.y + t * forward.y, from.z + t * forward.z};
}
HWY_INLINE Floats dot(const Point& a, const Point& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

HWY_INLINE Point cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

HWY_INLINE Floats length_of(const Point& vector) {
  return hn::Sqrt(dot(vector, vector));
}
HWY_INLINE Point scaled(const Point& vector, Floats by) {
  return {vector.x * by, vector.y * by, vector.z * by};
}
HWY_INLINE Point difference(const Point& to, const Point& from) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
}
HWY_INLINE Point normalised(const Point& vector) {
  return scaled(vector, all(1.0F) / length_of(vector));
}
HWY_INLINE Point where(Mask mask, const Point& yes, const Point& no) {
  return {where(mask, yes.x, no.x), where(mask, yes.y, no.y), where(mask, yes.z, no.z)};
}

// The bits of floats as words, and back.
HWY_INLINE Words words_of(Floats values) {
  return hn::BitCast(kWords, values);
}
HWY_INLINE Floats floats_of(Words bits) {
  return hn::BitCast(kFloats, bits);
}

// Of whole numbers up to 2^24.
HWY_INLINE Floats small_number_of(Words words) {
  return hn::ConvertTo(kFloats, hn::BitCast(kIntegers, words));
}
// Of whole numbers up to 2^32 - 1: rounded once.
HWY_INLINE Floats number_of(Words words) {
  const Words high = hn::ShiftRight<16>(words);
  const Words low = hn::And(words, hn::Set(kWords, 0xFFFFU));
  return small_number_of(high) * all(65536.0F) + small_number_of(low);
}

// Two neighbouring words of memory for each lane.
struct WordPairs {
  Words first;
  Words second;
};
// Gathers them together: that takes half as long as gathering each. `index`: of the first, from 0 to 2^30
// - 1.
HWY_INLINE WordPairs gathered_pairs(const void* words, Integers index) {
#if HWY_TARGET == HWY_SCALAR
  const auto* const base = static_cast<const std::uint32_t*>(words);
  return {hn::GatherIndex(kWords, base, index), hn::GatherIndex(kWords, base + 1, index)};
#else
  constexpr hn::Half<decltype(kWords)> kHalf;
  const Words offset = hn::ShiftLeft<2>(hn::BitCast(kWords, index));
  const auto lower = hn::BitCast(kPairOffsets, hn::PromoteTo(kPairs, hn::LowerHalf(kHalf, offset)));
  const auto upper = hn::BitCast(kPairOffsets, hn::PromoteTo(kPairs, hn::UpperHalf(kHalf, offset)));
  const auto* const base = static_cast<const std::uint64_t*>(words);
  const Words low = hn::BitCast(kWords, hn::GatherOffset(kPairs, base, lower));
  const Words high = hn::BitCast(kWords, hn::GatherOffset(kPairs, base, upper));
  return {hn::ConcatEven(kWords, high, low), hn::ConcatOdd(kWords, high, low)};
#endif
}

}  // namespace fanlight::lanes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
