// SPDX-License-Identifier: Apache-2.0
#include "server/codec/surface_coder.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

namespace fanlight {

namespace {

constexpr double kDeepestUnits = 65534;
// A difference in one byte is smaller; this byte announces two bytes in large_residuals.
constexpr std::uint16_t kLarge = 255;
// Where the differences around a pixel are larger together, it is rough: its own follows another statistics.
constexpr int kCalm = 6;
constexpr std::uint16_t kMostActivity = 40;

// Announces that some pixels of a block are in filled holes: those whose bits are set.
constexpr std::uint8_t kSomeFilled = 128;

/// Differences of either sign as 0, 1, 2, ...: 0, -1, 1, -2, ...
std::uint16_t folded(std::uint16_t difference) {
  const auto sign = static_cast<std::uint16_t>(difference >> 15U != 0 ? 0xFFFF : 0);
  return static_cast<std::uint16_t>(static_cast<std::uint16_t>(difference << 1U) ^ sign);
}

/// Compresses by zlib. `strategy`: Z_HUFFMAN_ONLY for differences, in which a search for repetitions costs
/// time and finds short ones, whose codes are longer than what they replace.
Result<void> compress(std::span<const std::uint8_t> first, std::span<const std::uint8_t> second, int strategy,
                      std::string& to) {
  const Error no_memory{ErrorCode::kUnavailable, "there is no memory to encode the surface"};
  z_stream stream{};
  constexpr int kWindowBits = 15;
  constexpr int kMemoryLevel = 9;
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kWindowBits, kMemoryLevel, strategy) != Z_OK)
    return no_memory;
  to.resize(deflateBound(&stream, first.size() + second.size()));
  stream.next_out = reinterpret_cast<Bytef*>(to.data());
  stream.avail_out = static_cast<uInt>(to.size());
  bool done = true;
  for (const auto& [bytes, flush, end] :
       {std::tuple{first, Z_NO_FLUSH, Z_OK}, std::tuple{second, Z_FINISH, Z_STREAM_END}}) {
    stream.next_in = const_cast<Bytef*>(bytes.data());
    stream.avail_in = static_cast<uInt>(bytes.size());
    if (bytes.empty() && flush == Z_NO_FLUSH) continue;
    done = done && deflate(&stream, flush) == end;
  }
  to.resize(stream.total_out);
  deflateEnd(&stream);
  if (!done) return no_memory;
  return {};
}

/// 0 where no ray met a surface, else 1 for uncertain to kSentCertainties + 1.
std::uint8_t sent_certainty(std::uint8_t certainty) {
  constexpr int kSteps = 254;  // shaders/certainty.h
  if (certainty == 0) return 0;
  return static_cast<std::uint8_t>(1 + ((certainty - 1) * kSentCertainties + kSteps / 2) / kSteps);
}

}  // namespace

double surface_unit_mm(const PictureView& view, double deepest_mm) {
  constexpr double kUnitsInAPixel = 12;
  const double pixel_mm = view.mm_per_pixel + deepest_mm * view.mm_per_pixel_per_mm;
  const double unit_mm = std::clamp(pixel_mm / kUnitsInAPixel, kFinestUnitMm, kCoarsestUnitMm);
  return std::max(unit_mm, deepest_mm / kDeepestUnits);
}

void SurfaceCoder::end_run() {
  while (run_ >= 128) {
    runs_.push_back(static_cast<std::uint8_t>(128 | (run_ & 127)));
    run_ >>= 7U;
  }
  runs_.push_back(static_cast<std::uint8_t>(std::exchange(run_, 0)));
}

void SurfaceCoder::pack_row(std::span<const float> depths_mm, double unit_mm) {
  // Before the first column everything is as at the first place above it.
  row_.depths[0] = above_.depths[0] = above_.depths[1];
  row_.differences[0] = 0;
  const auto per_mm = static_cast<float>(1 / unit_mm);
  for (std::size_t x = 0; x < depths_mm.size(); ++x) {
    const bool has_surface = depths_mm[x] >= 0;
    if (has_surface != in_surface_) {
      end_run();
      in_surface_ = has_surface;
    }
    ++run_;
    std::uint16_t& depth = row_.depths[x + 1];
    std::uint8_t& activity = row_.differences[x + 1];
    if (!has_surface) {
      depth = above_.depths[x + 1];
      activity = 0;
      continue;
    }
    depth = static_cast<std::uint16_t>(
        std::lround(std::min(depths_mm[x] * per_mm, static_cast<float>(kDeepestUnits))));
    const std::uint16_t difference =
        folded(static_cast<std::uint16_t>(depth - row_.depths[x] - above_.depths[x + 1] + above_.depths[x]));
    const int around =
        row_.differences[x] + above_.differences[x] + above_.differences[x + 1] + above_.differences[x + 2];
    auto& residuals = around <= kCalm ? calm_ : rough_;
    residuals.push_back(static_cast<std::uint8_t>(std::min(difference, kLarge)));
    if (difference >= kLarge) {
      large_.push_back(static_cast<std::uint8_t>(difference & 255));
      large_.push_back(static_cast<std::uint8_t>(difference >> 8U));
    }
    activity = static_cast<std::uint8_t>(std::min(difference, kMostActivity));
  }
  std::swap(row_, above_);
}

/// Of 2 x 2 pixels, the largest one: they vary slowly, but for holes that the filter has filled.
void SurfaceCoder::pack_certainties(const Picture& picture) {
  const SurfacePart& part = picture.stamp.view.part;
  for (std::uint32_t y = 0; y < part.height; y += 2) {
    for (std::uint32_t x = 0; x < part.width; x += 2) {
      bool has_surface = false;
      std::uint8_t largest = 0;
      std::uint8_t filled = 0;
      for (std::uint32_t row = y; row < std::min(y + 2, part.height); ++row) {
        for (std::uint32_t column = x; column < std::min(x + 2, part.width); ++column) {
          const std::size_t pixel = std::size_t{picture.width} * (part.top + row) + part.left + column;
          if (picture.depth_mm[pixel] < 0) continue;
          has_surface = true;
          largest = std::max(largest, picture.certainty[pixel]);
          if (picture.certainty[pixel] == 0)
            filled = static_cast<std::uint8_t>(filled | 1U << (2 * (row - y) + column - x));
        }
      }
      if (!has_surface) continue;
      if (largest > 0 && filled != 0) certainties_.push_back(static_cast<std::uint8_t>(kSomeFilled | filled));
      certainties_.push_back(sent_certainty(largest));
    }
  }
}

Result<void> SurfaceCoder::encode(const Picture& picture, v1::Surface& to) {
  const SurfacePart& part = picture.stamp.view.part;
  const std::size_t pixels = std::size_t{picture.width} * picture.height;
  if (picture.depth_mm.size() != pixels || picture.certainty.size() != pixels)
    return Error{ErrorCode::kBroken, "the picture has no depths, expected one for each pixel"};
  const double deepest_mm = std::max(0.F, std::ranges::max(picture.depth_mm));
  const double unit_mm = surface_unit_mm(picture.stamp.view, deepest_mm);
  for (Row* row : {&row_, &above_}) {
    row->depths.assign(part.width + 2, 0);
    row->differences.assign(part.width + 2, 0);
  }
  for (auto* bytes : {&runs_, &calm_, &rough_, &large_, &certainties_}) bytes->clear();
  in_surface_ = false;
  for (std::uint32_t y = 0; y < part.height; ++y) {
    const std::size_t first = std::size_t{picture.width} * (part.top + y) + part.left;
    pack_row(std::span(picture.depth_mm).subspan(first, part.width), unit_mm);
  }
  end_run();
  pack_certainties(picture);
  to.set_left(part.left);
  to.set_top(part.top);
  to.set_width(part.width);
  to.set_height(part.height);
  to.set_as_depth(part.as_depth);
  to.set_depth_unit_mm(unit_mm);
  to.set_calm_pixels(static_cast<std::uint32_t>(calm_.size()));
  // Certainties are 1 nearly everywhere, and lengths of runs repeat.
  if (auto done = compress(runs_, {}, Z_DEFAULT_STRATEGY, *to.mutable_runs()); !done) return done;
  if (auto done = compress(calm_, rough_, Z_HUFFMAN_ONLY, *to.mutable_residuals()); !done) return done;
  if (auto done = compress(large_, {}, Z_DEFAULT_STRATEGY, *to.mutable_large_residuals()); !done) return done;
  if (auto done = compress(certainties_, {}, Z_DEFAULT_STRATEGY, *to.mutable_certainties()); !done)
    return done;
  to.set_surface_id(picture.stamp.surface_id);  // last: who finds it has all maps
  return {};
}

}  // namespace fanlight
