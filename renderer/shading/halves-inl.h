// SPDX-License-Identifier: Apache-2.0
// Half floats in the halves of 32-bit words, as GLSL's packHalf2x16() and unpackHalf2x16().
#if defined(FANLIGHT_RENDERER_SHADING_HALVES) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_SHADING_HALVES
#undef FANLIGHT_RENDERER_SHADING_HALVES
#else
#define FANLIGHT_RENDERER_SHADING_HALVES
#endif

#include "renderer/lanes/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

using namespace lanes::HWY_NAMESPACE;

constexpr float kMostHalf = 65504.0F;
// A half float's exponent has a bias of 15, a float's of 127.
constexpr float kBiasUp = 0x1p112F;
constexpr float kBiasDown = 0x1p-112F;

// The half float in the low 16 bits of each word; infinities and NaN are not expected. The others are
// ignored.
HWY_INLINE Floats float_of(Words half) {
  const Words magnitude = hn::ShiftLeft<13>(hn::And(half, hn::Set(kWords, 0x7FFFU)));
  const Words sign = hn::ShiftLeft<16>(hn::And(half, hn::Set(kWords, 0x8000U)));
  const Floats value = hn::BitCast(kFloats, magnitude) * all(kBiasUp);
  return hn::BitCast(kFloats, hn::Or(hn::BitCast(kWords, value), sign));
}

// The nearest half float, in the low 16 bits; up to 65504.
HWY_INLINE Words half_of(Floats value) {
  const Words bits = hn::BitCast(kWords, value);
  const Words sign = hn::ShiftRight<16>(hn::And(bits, hn::Set(kWords, 0x80000000U)));
  const Floats magnitude = hn::Min(hn::Abs(value), all(kMostHalf)) * all(kBiasDown);
  const Words scaled = hn::BitCast(kWords, magnitude);
  const Words odd = hn::And(hn::ShiftRight<13>(scaled), hn::Set(kWords, 1U));
  return hn::Or(hn::ShiftRight<13>(scaled + hn::Set(kWords, 0xFFFU) + odd), sign);
}

// Four half floats of each pixel or place: 64 bits of memory.
struct Four {
  Floats x;
  Floats y;
  Floats z;
  Floats w;
};

HWY_INLINE Four unpacked(const WordPairs& words) {
  return {float_of(words.first), float_of(hn::ShiftRight<16>(words.first)), float_of(words.second),
          float_of(hn::ShiftRight<16>(words.second))};
}

HWY_INLINE WordPairs packed(const Four& values) {
  return {hn::Or(half_of(values.x), hn::ShiftLeft<16>(half_of(values.y))),
          hn::Or(half_of(values.z), hn::ShiftLeft<16>(half_of(values.w)))};
}

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
