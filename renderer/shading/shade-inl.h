// SPDX-License-Identifier: Apache-2.0
// The colour of a surface under the light: shaders/surface_shade.h, glass.h and mean_certainty.h for a vector
// of pixels. See there for the steps and their reasons.
#if defined(FANLIGHT_RENDERER_SHADING_SHADE) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_SHADING_SHADE
#undef FANLIGHT_RENDERER_SHADING_SHADE
#else
#define FANLIGHT_RENDERER_SHADING_SHADE
#endif

#include "renderer/shading/soft_light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

constexpr float kUncertainLight = 0.3F;
constexpr float kCertaintySteps = 254.0F;
constexpr float kFalling[3] = {1.15F, 1.0F, 0.85F};
constexpr float kWhite = 3.0F;
constexpr float kGlassGain = 1.8F;
constexpr float kLn2 = 0.693147180559945F;

// 0 to a power is 0.
HWY_INLINE Floats power(Floats base, float exponent) {
  const Floats logarithm = hn::Log(kFloats, hn::Max(base, all(1e-30F)));
  return hn::IfThenElseZero(hn::Gt(base, zero()), hn::Exp(kFloats, logarithm * all(exponent)));
}

// Eight bits of each word, as a number from 0 to 255.
template <int kFirstBit>
HWY_INLINE Floats byte_of(Words words) {
  const Words byte = hn::And(hn::ShiftRight<kFirstBit>(words), hn::Set(kWords, 0xFFU));
  return hn::ConvertTo(kFloats, hn::BitCast(kIntegers, byte));
}
HWY_INLINE Point rgb_of(Words words) {
  const Floats unit = all(1.0F / 255.0F);
  return {byte_of<0>(words) * unit, byte_of<8>(words) * unit, byte_of<16>(words) * unit};
}

class Shade {
 public:
  // `soft`: null where the light has no soft part. `colours`: of pass 1.
  Shade(const SurfaceMap& map, const SoftMaps* soft, const std::uint32_t* colours)
      : map_(map), soft_(soft), lighting_(map.lighting()), colours_(colours) {}

  // The displayed colours of consecutive pixels of a row, in the viewport or beside it.
  Point shown(int column, int row) const {
    if (!map_.has_view() || !map_.row_in_view(row)) return beside(column, row);
    const Mask inside = map_.in_view(pixels_from(column, row));
    if (is_empty(inside)) return beside(column, row);
    const Point colour = in_view(column, row);
    if (hn::AllTrue(kFloats, inside)) return colour;
    return where(inside, colour, beside(column, row));
  }

 private:
  Point in_view(int column, int row) const {
    if (lighting_.show == FANLIGHT_SHOW_COLOUR) return rgb_of(colours_from(column, row));
    const Floats depth = map_.depths_from(column, row);
    const Mask present = hn::Ge(depth, zero());
    if (lighting_.show == FANLIGHT_SHOW_DEPTH) {
      const Floats grey = all(1.0F) - (depth - all(lighting_.depth_white)) * all(lighting_.depth_scale);
      const Floats shown = hn::IfThenElseZero(present, clamped(grey, zero(), all(1.0F)));
      return {shown, shown, shown};
    }
    const Point haze = all(lighting_.haze);
    if (is_empty(present)) return displayed(haze);
    return displayed(where(present, shade(column, row, depth, present), haze));
  }

  // Beside the surface: the planes, or the colours of the volume from the pixels that have rays.
  Point beside(int column, int row) const {
    const int left = lighting_.colours_from_left;
    const int last = static_cast<int>(lighting_.width) - 1;
    const std::uint32_t* const colours = colours_ + static_cast<std::size_t>(row) * lighting_.width;
    const Point colour = rgb_of(read_row(colours, column - left, 0, last));
    if (left <= 0) return colour;
    const Pixels from = pixels_from(column - left, row);
    const Mask known = map_.has_view() ? map_.in_view(from) : none();
    return where(known, colour, {zero(), zero(), zero()});
  }

  Words colours_from(int column, int row) const {
    const std::uint32_t* const colours =
        colours_ + static_cast<std::size_t>(map_.clamped_row(row)) * lighting_.width;
    return read_row(colours, column, lighting_.view_left, lighting_.view_right);
  }

  Neighbours neighbours(int column, int row, Floats depth) const {
    return {.here = depth,
            .left = map_.depths_from(column - 1, row),
            .right = map_.depths_from(column + 1, row),
            .above = map_.depths_from(column, row - 1),
            .below = map_.depths_from(column, row + 1)};
  }

  Point shade(int column, int row, Floats depth, Mask present) const {
    const Pixels pixel = pixels_from(column, row);
    const Point at = map_.point_at(pixel, depth);
    const Point normal = map_.normal_at(pixel, neighbours(column, row, depth));
    const Point eye = {zero(), zero(), all(lighting_.eye_height)};
    const Point to_eye =
        map_.perspective() ? normalised(difference(eye, at)) : Point{zero(), zero(), all(1.0F)};
    Four direct = {all(1.0F), all(1.0F), all(1.0F), all(1.0F)};
    Four scattered = {zero(), zero(), zero(), zero()};
    if (soft_ != nullptr) soft_light_around(column, row, depth, direct, scattered);
    Point matt = {zero(), zero(), zero()};
    Point shine = matt;
    for (int lamp = 0; lamp < lighting_.lamps; ++lamp) {
      const Point to_light = map_.direction_to_light(at, lamp);
      const Floats facing = hn::Max(dot(normal, to_light), zero());
      const Mask lit = hn::And(present, hn::Gt(facing, zero()));
      Floats arrives = soft_ != nullptr ? of_lamp(direct, lamp) : map_.direct_light(at, depth, lit, lamp);
      arrives = mixed(arrives, all(1.0F), all(lighting_.glass));
      add_matt(matt, lamp, facing * arrives, of_lamp(scattered, lamp));
      if (lighting_.specular > 0.0F) {
        const Point sum = {to_light.x + to_eye.x, to_light.y + to_eye.y, to_light.z + to_eye.z};
        const Floats mirrored = hn::Max(dot(normal, normalised(sum)), zero());
        const Floats highlight = hn::IfThenElseZero(lit, power(mirrored, lighting_.shininess));
        shine =
            fanlight::lanes::HWY_NAMESPACE::at(shine, highlight * arrives, all(lighting_.lamp_colours[lamp]));
      }
    }
    const Floats away = all(1.0F) - hn::Max(dot(normal, to_eye), zero());
    const Floats everywhere = (all(lighting_.ambient) + all(lighting_.rim) * away * away * away) * direct.w;
    Point light = {sent(everywhere, matt.x, shine.x, 0), sent(everywhere, matt.y, shine.y, 1),
                   sent(everywhere, matt.z, shine.z, 2)};
    light = scaled(light, mixed(all(kUncertainLight), all(1.0F), certainty_about(column, row)));
    if (lighting_.glass > 0.0F) light = as_glass(column, row, at, light, away);
    return faded(light, depth);
  }

  // Matt light of one lamp: reflected where it arrives, or scattered under the surface.
  void add_matt(Point& matt, int lamp, Floats arrives, Floats scattered) const {
    const auto& colour = lighting_.lamp_colours[lamp];
    const shaders::vec3 spread = (1.0F - lighting_.glass) * lighting_.scattered;
    matt.x = matt.x + all(colour.x) * mixed(arrives, scattered, all(spread.x));
    matt.y = matt.y + all(colour.y) * mixed(arrives, scattered, all(spread.y));
    matt.z = matt.z + all(colour.z) * mixed(arrives, scattered, all(spread.z));
  }

  // One component of the light that the material sends.
  Floats sent(Floats everywhere, Floats matt, Floats shine, int component) const {
    const Floats sum = everywhere * all(lighting_.light_colour[component]) + all(lighting_.diffuse) * matt;
    return sum * all(lighting_.material[component]) + all(lighting_.specular) * shine;
  }

  // Far tissue is darker, and at least as light as the haze.
  Point faded(const Point& light, Floats depth) const {
    const Point haze = all(lighting_.haze);
    Point faded = light;
    if (lighting_.halves_per_mm > 0.0F) {
      const Floats halves =
          hn::Max(depth - all(lighting_.half_from), zero()) * all(-kLn2 * lighting_.halves_per_mm);
      faded = {light.x * hn::Exp(kFloats, halves * all(kFalling[0])),
               light.y * hn::Exp(kFloats, halves * all(kFalling[1])),
               light.z * hn::Exp(kFloats, halves * all(kFalling[2]))};
    }
    return {hn::Max(faded.x, haze.x), hn::Max(faded.y, haze.y), hn::Max(faded.z, haze.z)};
  }

  // The mean of the rays about a pixel that met a surface.
  Floats certainty_about(int column, int row) const {
    Floats sum = zero();
    Floats met = zero();
    for (int down = -1; down <= 1; ++down) {
      for (int right = -1; right <= 1; ++right) {
        const Floats alpha = byte_of<24>(colours_from(column + right, row + down));
        sum = sum + hn::Max(alpha - all(1.0F), zero());
        met = met + hn::Min(alpha, all(1.0F));
      }
    }
    return sum * all(1.0F / kCertaintySteps) / hn::Max(met, all(1.0F));
  }

  // Between the up to four places around a pixel on the same surface.
  void soft_light_around(int column, int row, Floats depth, Four& direct, Four& scattered) const {
    const Pixels pixel = pixels_from(column, row);
    const Floats half = hn::Floor(pixel.x * all(0.5F));
    const Floats part = pixel.x * all(0.5F) - half;
    const float part_down = row % 2 == 0 ? 0.0F : 0.5F;
    const Floats last = all(static_cast<float>(soft_->across() - 1));
    Four direct_sum = {zero(), zero(), zero(), zero()};
    Four scattered_sum = direct_sum;
    Floats weights = zero();
    for (int each = 0; each < 4; ++each) {
      const bool right = (each & 1) != 0;
      const bool below = each >> 1 != 0;
      const float share_down = below ? part_down : 1.0F - part_down;
      if (share_down == 0.0F) continue;
      const Pixels place = {hn::Min(right ? half + all(1.0F) : half, last),
                            all(static_cast<float>(std::min(row / 2 + (below ? 1 : 0), soft_->down() - 1)))};
      const Four second = soft_->at(place, 1);
      const Four first = soft_->at(place, 0);
      const Floats apart = hn::Abs(second.w - depth) / all(lighting_.same_surface);
      const Floats alike = hn::Max(all(1.0F) - apart, all(0.001F));
      const Floats share = (right ? part : all(1.0F) - part) * all(share_down);
      const Floats weight = hn::IfThenElseZero(hn::Ge(second.w, zero()), share * alike);
      add(direct_sum, weight, first);
      add(scattered_sum, weight, second);
      weights = weights + weight;
    }
    const Mask known = hn::Gt(weights, zero());
    const Floats unit = hn::IfThenElseZero(known, all(1.0F) / weights);
    direct = {where(known, unit * direct_sum.x, all(1.0F)), where(known, unit * direct_sum.y, all(1.0F)),
              where(known, unit * direct_sum.z, all(1.0F)), where(known, unit * direct_sum.w, all(1.0F))};
    scattered = {unit * scattered_sum.x, unit * scattered_sum.y, unit * scattered_sum.z, depth};
  }

  static void add(Four& sum, Floats weight, const Four& more) {
    sum.x = sum.x + weight * more.x;
    sum.y = sum.y + weight * more.y;
    sum.z = sum.z + weight * more.z;
    sum.w = sum.w + weight * more.w;
  }

  // The light of what lies behind a surface of glass, mixed with that of its outline.
  Point as_glass(int column, int row, const Point& at, const Point& light, Floats away) const {
    const Point layers = layers_about(column, row);
    const Point behind = layers_light(layers, at);
    const Floats opacity = mixed(all(1.0F), away * away * away, all(lighting_.glass));
    const float gain = 1.0F + lighting_.glass * (kGlassGain - 1.0F);
    const auto& material = lighting_.material;
    return {all(gain) * mixed(behind.x * all(material.x), light.x, opacity),
            all(gain) * mixed(behind.y * all(material.y), light.y, opacity),
            all(gain) * mixed(behind.z * all(material.z), light.z, opacity)};
  }

  // The binomial mean over 3 x 3 pixels. x: opacity; y, z: the normal to the right and upwards, times it.
  Point layers_about(int column, int row) const {
    Point sum = {zero(), zero(), zero()};
    for (int down = -1; down <= 1; ++down) {
      for (int right = -1; right <= 1; ++right) {
        const Words kept = colours_from(column + right, row + down);
        const int share = (right == 0 ? 2 : 1) * (down == 0 ? 2 : 1);
        const Floats root = byte_of<0>(kept) * all(1.0F / 255.0F);
        const Floats opacity = root * root * all(static_cast<float>(share) / 16.0F);
        const Floats unit = all(1.0F / 127.0F);
        sum.x = sum.x + opacity;
        sum.y = sum.y + opacity * ((byte_of<8>(kept) - all(128.0F)) * unit);
        sum.z = sum.z + opacity * ((byte_of<16>(kept) - all(128.0F)) * unit);
      }
    }
    return sum;
  }

  Point layers_light(const Point& layers, const Point& at) const {
    const Floats ambient = all(lighting_.ambient) * layers.x;
    Point light = scaled(all(lighting_.light_colour), ambient);
    for (int lamp = 0; lamp < lighting_.lamps; ++lamp) {
      const Point to_light = map_.direction_to_light(at, lamp);
      const Floats lit = all(0.5F) * (layers.x + layers.y * to_light.x + layers.z * to_light.y);
      light = fanlight::lanes::HWY_NAMESPACE::at(light, all(lighting_.diffuse) * hn::Max(lit, zero()),
                                                 all(lighting_.lamp_colours[lamp]));
    }
    return light;
  }

  // Light to what a screen can show.
  Point displayed(const Point& light) const {
    return {encoded(toned(light.x)), encoded(toned(light.y)), encoded(toned(light.z))};
  }
  Floats toned(Floats light) const {
    const Floats exposed = all(lighting_.exposure) * light;
    if (lighting_.film == 0) return exposed;
    return exposed * (all(1.0F) + exposed * all(1.0F / (kWhite * kWhite))) / (all(1.0F) + exposed);
  }
  static Floats encoded(Floats linear) {
    const Floats bounded = clamped(linear, zero(), all(1.0F));
    const Floats curve = all(1.055F) * power(bounded, 1.0F / 2.4F) - all(0.055F);
    return where(hn::Lt(bounded, all(0.0031308F)), all(12.92F) * bounded, curve);
  }

  const SurfaceMap& map_;
  const SoftMaps* soft_;
  const shaders::LightParameters& lighting_;
  const std::uint32_t* colours_;
};

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
