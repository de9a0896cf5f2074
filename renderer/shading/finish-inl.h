// SPDX-License-Identifier: Apache-2.0
// Pass 3: shaders/outline_colour.h and finish_colour.h for a vector of pixels. See there for the steps and
// their reasons.
#if defined(FANLIGHT_RENDERER_SHADING_FINISH) == defined(HWY_TARGET_TOGGLE)
#ifdef FANLIGHT_RENDERER_SHADING_FINISH
#undef FANLIGHT_RENDERER_SHADING_FINISH
#else
#define FANLIGHT_RENDERER_SHADING_FINISH
#endif

#include "renderer/shading/halves-inl.h"
#include "renderer/shading/surface_map-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fanlight::shading::HWY_NAMESPACE {

constexpr float kDiffusionStep = 0.2F;

HWY_INLINE Floats brightness(const Point& colour) {
  return all(0.2126F) * colour.x + all(0.7152F) * colour.y + all(0.0722F) * colour.z;
}

// The lit picture: four half floats a pixel, displayed values. Beyond its border, the border.
class LitPicture {
 public:
  LitPicture(const shaders::LightParameters& lighting, std::uint32_t* words)
      : width_(static_cast<int>(lighting.width)), height_(static_cast<int>(lighting.height)), words_(words) {}

  WordPairs words_from(int column, int row) const {
    return read_pairs(row_of(std::clamp(row, 0, height_ - 1)), column, 0, width_ - 1);
  }
  // Of consecutive pixels of a row.
  Point from(int column, int row) const {
    const Four colour = unpacked(words_from(column, row));
    return {colour.x, colour.y, colour.z};
  }
  void write(const WordPairs& words, int column, int row, int count) const {
    write_pairs(words, row_of(row) + 2 * column, count);
  }
  void write(const Point& colour, int column, int row, int count) const {
    write(packed({colour.x, colour.y, colour.z, all(1.0F)}), column, row, count);
  }

 private:
  std::uint32_t* row_of(int row) const {
    return words_ + 2 * static_cast<std::size_t>(row) * static_cast<std::size_t>(width_);
  }

  int width_;
  int height_;
  std::uint32_t* words_;
};

HWY_INLINE Point flow(const Point& from, const Point& to, float scale) {
  const Floats step = (brightness(from) - brightness(to)) * all(scale);
  return scaled(difference(from, to), all(1.0F) / (all(1.0F) + step * step));
}

// After one step of the diffusion.
HWY_INLINE Point diffused_colour(const LitPicture& lit, int column, int row, float scale) {
  const Point here = lit.from(column, row);
  const Point right = flow(lit.from(column + 1, row), here, scale);
  const Point left = flow(lit.from(column - 1, row), here, scale);
  const Point below = flow(lit.from(column, row + 1), here, scale);
  const Point above = flow(lit.from(column, row - 1), here, scale);
  const Floats step = all(kDiffusionStep);
  return {here.x + step * (right.x + left.x + below.x + above.x),
          here.y + step * (right.y + left.y + below.y + above.y),
          here.z + step * (right.z + left.z + below.z + above.z)};
}

// The colour map at the brightness of a colour.
HWY_INLINE Point mapped(const shaders::LightParameters& lighting, const Point& colour) {
  const Floats position =
      clamped(brightness(colour), zero(), all(1.0F)) * all(static_cast<float>(FANLIGHT_MAP_POINTS - 1));
  const Floats below = hn::Min(hn::Floor(position), all(static_cast<float>(FANLIGHT_MAP_POINTS - 2)));
  const Floats part = position - below;
  Point from = all(lighting.map_points[0]);
  Point to = all(lighting.map_points[1]);
  for (int point = 1; point + 1 < FANLIGHT_MAP_POINTS; ++point) {
    const Mask here = hn::Eq(below, all(static_cast<float>(point)));
    from = where(here, all(lighting.map_points[point]), from);
    to = where(here, all(lighting.map_points[point + 1]), to);
  }
  return {mixed(from.x, to.x, part), mixed(from.y, to.y, part), mixed(from.z, to.z, part)};
}

// Packed RGBA8.
HWY_INLINE Words finished_pixels(const shaders::LightParameters& lighting, const LitPicture& lit, int column,
                                 int row) {
  Point colour = lit.from(column, row);
  if (lighting.mean != 0) {
    const Point right = lit.from(column + 1, row);
    const Point below = lit.from(column, row + 1);
    const Point both = lit.from(column + 1, row + 1);
    const Floats quarter = all(0.25F);
    colour = {quarter * (colour.x + (right.x + below.x + both.x)),
              quarter * (colour.y + (right.y + below.y + both.y)),
              quarter * (colour.z + (right.z + below.z + both.z))};
  }
  if (lighting.map_colours != 0) colour = mapped(lighting, colour);
  const Floats scale = all(255.0F);
  const Words red = hn::BitCast(kWords, hn::NearestInt(clamped(colour.x, zero(), all(1.0F)) * scale));
  const Words green = hn::BitCast(kWords, hn::NearestInt(clamped(colour.y, zero(), all(1.0F)) * scale));
  const Words blue = hn::BitCast(kWords, hn::NearestInt(clamped(colour.z, zero(), all(1.0F)) * scale));
  const Words opaque = hn::Set(kWords, 0xFF000000U);
  return hn::Or(hn::Or(red, hn::ShiftLeft<8>(green)), hn::Or(hn::ShiftLeft<16>(blue), opaque));
}

// The outlines of surfaces by coverage.
class Outline {
 public:
  Outline(const SurfaceMap& map, const LitPicture& lit) : map_(map), lit_(lit), lighting_(map.lighting()) {}

  // The outlined picture of consecutive pixels of a row. `wanted`: those in the viewport that may have an
  // outline; the others stay as they are. Precondition: the row lies in the viewport.
  WordPairs outlined(int column, int row, Mask wanted) const {
    const WordPairs kept = lit_.words_from(column, row);
    const Floats front = front_of(column, row);
    const Mask looks = hn::And(wanted, hn::Lt(front, all(kMostDepth)));
    if (is_empty(looks)) return kept;
    const Floats farthest = front + all(lighting_.same_surface);
    const Coverage coverage = coverage_of(column, row, farthest);
    const Mask is_inside = lies_inside(map_.clamped_depths_from(column, row), farthest);
    const Floats whole = hn::IfThenElseZero(is_inside, all(1.0F));
    const Mask mixes =
        hn::And(looks, hn::And(hn::Gt(coverage.inside, zero()), hn::Ne(coverage.covered, whole)));
    if (is_empty(mixes)) return kept;
    const Floats own = where(is_inside, coverage.covered, all(1.0F) - coverage.covered);
    return mixed_with_other_side(column, row, {farthest, is_inside, mixes, own}, kept);
  }

 private:
  struct Coverage {
    Floats inside;   // weighted pixels of the window that are inside
    Floats covered;  // share of the pixel, 0 to 1
  };
  struct Sides {
    Floats farthest;
    Mask is_inside;
    Mask mixes;
    Floats own;
  };

  static Mask lies_inside(Floats depth, Floats farthest) {
    return hn::And(hn::Ge(depth, zero()), hn::Le(depth, farthest));
  }

  // Smallest depth of nine pixels of the window; FANLIGHT_MAX_DEPTH where no outline is looked for.
  Floats front_of(int column, int row) const {
    const int radius = lighting_.outline_radius;
    Floats nearest = all(kMostDepth);
    Floats smallest = all(kMostDepth);
    Floats largest = all(kNoSurface);
    for (int down = -radius; down <= radius; down += radius) {
      for (int across = -radius; across <= radius; across += radius) {
        const Floats depth = map_.clamped_depths_from(column + across, row + down);
        nearest = where(hn::Ge(depth, zero()), hn::Min(nearest, depth), nearest);
        smallest = hn::Min(smallest, depth);
        largest = hn::Max(largest, depth);
      }
    }
    const Mask one_surface =
        hn::And(hn::Ge(smallest, zero()), hn::Le(largest - smallest, all(lighting_.same_surface)));
    const Mask even = hn::Or(hn::Lt(largest, zero()), one_surface);
    return where(even, all(kMostDepth), nearest);
  }

  Coverage coverage_of(int column, int row, Floats farthest) const {
    const int radius = lighting_.outline_radius;
    Floats weights = zero();
    Floats inside = zero();
    Pixels offsets = {zero(), zero()};
    Pixels inside_offsets = {zero(), zero()};
    for (int down = -radius; down <= radius; ++down) {
      if (!map_.row_in_view(row + down)) continue;
      for (int across = -radius; across <= radius; ++across) {
        const float square = static_cast<float>(across * across + down * down);
        const float share = 1.0F - square * lighting_.outline_fall;
        if (share <= 0.0F) continue;
        const Mask there = map_.in_view(pixels_from(column + across, row + down));
        const Floats depth = map_.clamped_depths_from(column + across, row + down);
        const Floats weight = hn::IfThenElseZero(there, all(share));
        const Floats part = hn::IfThenElseZero(lies_inside(depth, farthest), weight);
        const Floats right = all(static_cast<float>(across));
        const Floats below = all(static_cast<float>(down));
        weights = weights + weight;
        inside = inside + part;
        offsets = {offsets.x + weight * right, offsets.y + weight * below};
        inside_offsets = {inside_offsets.x + part * right, inside_offsets.y + part * below};
      }
    }
    const Floats unit = all(1.0F) / hn::Max(weights, all(1e-6F));
    const Floats share = inside * unit;
    const Floats x = inside_offsets.x - share * offsets.x;
    const Floats y = inside_offsets.y - share * offsets.y;
    const Floats towards = hn::Max(hn::Sqrt(x * x + y * y) * unit, all(1e-6F));
    const Floats distance = (share - all(0.5F)) * all(lighting_.outline_scale) / towards;
    return {inside, clamped(all(0.5F) + distance, zero(), all(1.0F))};
  }

  // The light of the other side comes from the pixels next to each.
  WordPairs mixed_with_other_side(int column, int row, const Sides& sides, const WordPairs& kept) const {
    Point light = {zero(), zero(), zero()};
    Floats pixels = zero();
    for (int down = -1; down <= 1; ++down) {
      if (!map_.row_in_view(row + down)) continue;
      for (int across = -1; across <= 1; ++across) {
        const Mask there = map_.in_view(pixels_from(column + across, row + down));
        const Floats depth = map_.clamped_depths_from(column + across, row + down);
        const Mask other = hn::And(there, hn::Xor(lies_inside(depth, sides.farthest), sides.is_inside));
        const Floats one = hn::IfThenElseZero(other, all(1.0F));
        light = squares_added(light, lit_.from(column + across, row + down), one);
        pixels = pixels + one;
      }
    }
    const Floats unit = all(1.0F) / hn::Max(pixels, all(1.0F));
    const Point zeros = {zero(), zero(), zero()};
    const Point here = squares_added(zeros, lit_.from(column, row), all(1.0F));
    const Point colour = {hn::Sqrt(mixed(light.x * unit, here.x, sides.own)),
                          hn::Sqrt(mixed(light.y * unit, here.y, sides.own)),
                          hn::Sqrt(mixed(light.z * unit, here.z, sides.own))};
    const WordPairs changed = packed({colour.x, colour.y, colour.z, all(1.0F)});
    const auto changes = hn::MaskFromVec(
        hn::BitCast(kWords, hn::VecFromMask(kFloats, hn::And(sides.mixes, hn::Gt(pixels, zero())))));
    return {hn::IfThenElse(changes, changed.first, kept.first),
            hn::IfThenElse(changes, changed.second, kept.second)};
  }

  static Point squares_added(const Point& sum, const Point& colour, Floats weight) {
    return {sum.x + weight * colour.x * colour.x, sum.y + weight * colour.y * colour.y,
            sum.z + weight * colour.z * colour.z};
  }

  const SurfaceMap& map_;
  const LitPicture& lit_;
  const shaders::LightParameters& lighting_;
};

}  // namespace fanlight::shading::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
