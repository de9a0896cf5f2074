// SPDX-License-Identifier: Apache-2.0
#include "renderer/survey/echo_survey.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "proto/model/scanned_sector.hpp"

namespace fanlight {

namespace {

// Side of a block, pixels: that of the guided filter's largest window, so that both see the same deviation.
constexpr std::uint32_t kSide = 7;
// Speckle's deviation over what is left of it without the means of rows and columns (measured: scanned scenes
// of renderer/RESULTS.md). Of grains that are long in one direction less is left.
constexpr double kOverWithin = 1.4;
// Of the tissue. Log-compressed speckle has 0.12 to 0.2: what is rougher is not compressed, or crossed by a
// surface.
constexpr double kLeastRoughRatio = 0.25;
constexpr std::uint32_t kMostFrames = 16;
constexpr std::uint32_t kMostAcross = 24;  // blocks of a frame
constexpr std::uint32_t kMostDown = 24;
// Layers of equal thickness below the probe's face, to the depth of the frames. Those next to the face that
// are bright all over are left out: reverberation is there, and not of tissue. Not where they reach further
// than it.
constexpr std::size_t kLayers = 24;
constexpr std::size_t kMostBrightLayers = 8;
constexpr double kBrightAllOver = 0.9;
// Of the contrast: tissue fades by less from the first layer to the middle one, reverberation by more.
constexpr double kMostFading = 0.4;
// Whether it fades cannot be seen from this grey level on.
constexpr double kSaturated = 220;
// Levels that lie closer together are one.
constexpr double kLeastStep = 4;
// The method parts pure speckle too, into blocks whose medians differ by up to 1.1 of its deviation
// (measured: scanned scenes of renderer/RESULTS.md); without log compression by up to a quarter of its mean.
constexpr double kLeastOverSpeckle = 1.8;
constexpr double kLeastRatio = 1.6;
// In speckle alone dark blocks are as rough as bright ones, also as a share of their mean. Where they are
// quieter than this share, there is a body in clean fluid, and its bright blocks are rough by its border.
constexpr double kLeastDarkRoughness = 0.35;
// Speckle has at most 0.52 of its mean (Rayleigh's distribution). Where the fluid is black, blocks on the
// border of a body have more.
constexpr double kMostSpeckleRatio = 0.7;
// Blocks of a small body are less than this share of all.
constexpr double kSmallShare = 0.02;
// Deviations above black from which on it does not cut speckle off.
constexpr double kFullSpeckle = 1.8;
// No block of speckle alone lies so many of its deviations above the others: means of blocks have at most
// half of its deviation.
constexpr double kBeyondSpeckle = 2.5;
constexpr std::uint32_t kLeastBlocks = 4;
// More of a layer is reverberation, not a small body.
constexpr double kMostOfALayer = 0.25;
// Log-compressed speckle that black cuts off has less than its mean. Dark blocks on a border have more.
constexpr double kMostCutOffRatio = 1;
// So many volumes in a row are flat before known levels are given up.
constexpr std::uint32_t kFlatVolumes = 3;
// Of the steady mean.
constexpr double kShareOfNew = 0.2;
constexpr double kLeastChange = 0.1;
constexpr double kOtherChange = 0.5;

bool differ(double from, double to, double share) {
  return std::abs(to - from) > share * from;
}

bool differ(const EchoLevels& from, const EchoLevels& to, double share) {
  const double contrast = from.tissue - from.fluid;
  return differ(contrast, to.tissue - to.fluid, share) || differ(from.noise, to.noise, share) ||
         std::abs(to.least_tissue() - from.least_tissue()) > share * contrast;
}

using Histogram = std::array<std::uint32_t, 256>;

struct Block {
  std::uint8_t darkest = 0;
  double mean = 0;
  double deviation = 0;
  double within = 0;  ///< deviation from the means of rows and columns
  double peak = 0;    ///< the largest of these means
};

/// Between the means of the rows, or columns, of a block.
double variance_of(const std::array<std::uint32_t, kSide>& sums, double mean) {
  double squared = 0;
  for (const std::uint32_t sum : sums) {
    const double apart = sum / double{kSide} - mean;
    squared += apart * apart;
  }
  return squared / kSide;
}

Block block_at(std::span<const std::uint8_t> pixels, std::uint32_t columns, std::uint32_t column,
               std::uint32_t row) {
  std::array<std::uint32_t, kSide> in_rows{};
  std::array<std::uint32_t, kSide> in_columns{};
  std::uint32_t sum = 0;
  std::uint32_t squares = 0;
  std::uint8_t darkest = 255;
  for (std::uint32_t down = 0; down < kSide; ++down) {
    const std::uint8_t* const line = &pixels[std::size_t{row + down} * columns + column];
    for (std::uint32_t across = 0; across < kSide; ++across) {
      in_rows[down] += line[across];
      in_columns[across] += line[across];
      squares += std::uint32_t{line[across]} * line[across];
      darkest = std::min(darkest, line[across]);
    }
    sum += in_rows[down];
  }
  constexpr double kPixels = kSide * kSide;
  const double mean = sum / kPixels;
  const double variance = std::max(0.0, squares / kPixels - mean * mean);
  const double within = std::max(0.0, variance - variance_of(in_rows, mean) - variance_of(in_columns, mean));
  const double peak =
      std::max(*std::ranges::max_element(in_rows), *std::ranges::max_element(in_columns)) / double{kSide};
  return {.darkest = darkest,
          .mean = mean,
          .deviation = std::sqrt(variance),
          .within = std::sqrt(within),
          .peak = peak};
}

/// Calls `use(block, layer, is_scanned)` for the blocks of a grid over some frames, within the sector.
template <typename Use>
void for_each_block(const Volume& volume, Use&& use) {
  const FanGeometry& geometry = volume.geometry();
  const auto order = volume.by_angle();
  const auto frames = std::min<std::uint32_t>(kMostFrames, static_cast<std::uint32_t>(order.size()));
  if (geometry.columns < kSide || geometry.rows < kSide) return;
  const double depth_mm = geometry.depth_mm();
  // Where the sector is not known, what is all black is the border of the scanner's picture.
  const bool has_border = geometry.kind == FrameKind::kCartesian && geometry.sector.half_angle_deg == 0;
  const std::uint32_t across = std::min(kMostAcross, geometry.columns / kSide);
  const std::uint32_t down = std::min(kMostDown, geometry.rows / kSide);
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    const auto pixels = volume.frame_pixels(order[(2 * frame + 1) * order.size() / (2 * frames)]);
    for (std::uint32_t j = 0; j < down; ++j) {
      const std::uint32_t row = j * (geometry.rows - kSide) / std::max(1U, down - 1);
      for (std::uint32_t i = 0; i < across; ++i) {
        const std::uint32_t column = i * (geometry.columns - kSide) / std::max(1U, across - 1);
        constexpr double kMiddle = (kSide - 1) / 2.0;
        if (!in_sector(geometry, column + kMiddle, row + kMiddle)) continue;
        const Block block = block_at(pixels, geometry.columns, column, row);
        const bool is_scanned =
            geometry.zero_is_unscanned ? block.darkest > 0 : !has_border || block.mean > 0;
        const double share = from_face_mm(geometry, column + kMiddle, row + kMiddle) / depth_mm;
        use(block, static_cast<std::size_t>(std::clamp(share, 0.0, 0.999) * kLayers), is_scanned);
      }
    }
  }
}

std::size_t bin_of(double level) {
  return static_cast<std::size_t>(std::clamp(std::lround(level), 0L, 255L));
}

double median_of(const Histogram& counts, std::size_t from, std::size_t to) {
  std::uint64_t all = 0;
  for (std::size_t bin = from; bin < to; ++bin) all += counts[bin];
  std::uint64_t below = 0;
  for (std::size_t bin = from; bin < to; ++bin) {
    below += counts[bin];
    if (2 * below >= all && all > 0) return static_cast<double>(bin);
  }
  return 0;
}

/// The first bin of the bright class: the largest variance between the classes. 0 without two classes.
std::size_t parted_at(const Histogram& counts) {
  double all = 0;
  double sum = 0;
  for (std::size_t bin = 0; bin < counts.size(); ++bin) {
    all += counts[bin];
    sum += static_cast<double>(bin) * counts[bin];
  }
  double dark = 0;
  double dark_sum = 0;
  double best = -1;
  std::size_t at = 0;
  for (std::size_t bin = 0; bin + 1 < counts.size(); ++bin) {
    dark += counts[bin];
    dark_sum += static_cast<double>(bin) * counts[bin];
    if (dark == 0 || dark == all) continue;
    const double apart = dark_sum / dark - (sum - dark_sum) / (all - dark);
    const double between = dark * (all - dark) * apart * apart;
    if (between <= best) continue;
    best = between;
    at = bin + 1;
  }
  return at;
}

/// Blocks by layer and mean.
struct Blocks {
  std::array<Histogram, kLayers> layers{};
  std::array<std::uint32_t, kLayers> not_scanned{};
  std::array<bool, kLayers> counted{};  ///< layers that are not left out

  Histogram means() const {
    Histogram sum{};
    for (std::size_t layer = 0; layer < kLayers; ++layer) {
      if (!counted[layer]) continue;
      for (std::size_t bin = 0; bin < sum.size(); ++bin) sum[bin] += layers[layer][bin];
    }
    return sum;
  }
};

std::uint32_t count_from(const Histogram& means, std::size_t bin) {
  return std::accumulate(means.begin() + static_cast<std::ptrdiff_t>(bin), means.end(), 0U);
}

/// Whether at least a share of the blocks of a layer lie from a bin on; false without any.
bool lie_beyond(const Blocks& blocks, std::size_t layer, std::size_t bin, double share) {
  const std::uint32_t all = count_from(blocks.layers[layer], 0) + blocks.not_scanned[layer];
  return all > 0 && count_from(blocks.layers[layer], bin) >= share * all;
}

/// Leaves out the layers next to the probe that are bright all over. What is bright changes with the layers
/// that count.
void leave_reverberation_out(Blocks& blocks) {
  for (std::size_t first = 0; first <= kMostBrightLayers; ++first) {
    const std::size_t bright = parted_at(blocks.means());
    // Small frames have layers without any block.
    const bool is_empty = count_from(blocks.layers[first], 0) + blocks.not_scanned[first] == 0;
    if (bright == 0 || !(is_empty || lie_beyond(blocks, first, bright, kBrightAllOver))) return;
    blocks.counted[first] = false;
  }
  // Tissue reaches from the probe to here.
  blocks.counted.fill(true);
}

Blocks blocks_of(const Volume& volume) {
  Blocks blocks;
  blocks.counted.fill(true);
  for_each_block(volume, [&](const Block& block, std::size_t layer, bool is_scanned) {
    ++(is_scanned ? blocks.layers[layer][bin_of(block.mean)] : blocks.not_scanned[layer]);
  });
  leave_reverberation_out(blocks);
  return blocks;
}

/// How rough the blocks of both classes are, medians.
struct Roughness {
  double bright = 0;
  double bright_within = 0;  ///< without the means of rows and columns
  double bright_peak = 0;    ///< the largest of these means
  double dark = 0;
};

Roughness roughness_of(const Volume& volume, const Blocks& blocks, std::size_t bright) {
  Histogram deviations{};
  Histogram within{};
  Histogram peaks{};
  Histogram dark{};
  for_each_block(volume, [&](const Block& block, std::size_t layer, bool is_scanned) {
    if (!is_scanned || !blocks.counted[layer]) return;
    const bool is_dark = bin_of(block.mean) < bright;
    ++(is_dark ? dark : deviations)[bin_of(block.deviation)];
    if (is_dark) return;
    ++within[bin_of(block.within)];
    ++peaks[bin_of(block.peak)];
  });
  return {.bright = median_of(deviations, 0, deviations.size()),
          .bright_within = median_of(within, 0, within.size()),
          .bright_peak = median_of(peaks, 0, peaks.size()),
          .dark = median_of(dark, 0, dark.size())};
}

/// The levels of blocks parted at a bin: known, flat or neither.
EchoLevels parted_levels(const Volume& volume, const Blocks& blocks, std::size_t bright) {
  const Histogram means = blocks.means();
  const Roughness rough = roughness_of(volume, blocks, bright);
  EchoLevels levels{.fluid = median_of(means, 0, bright), .tissue = median_of(means, bright, means.size())};
  levels.noise = std::max(1.0, rough.bright);
  // A thin surface that crosses the bright blocks makes them as rough as speckle without log compression. In
  // speckled fluid, which shows that there is speckle, it is known by its own brightness, not that of its
  // blocks.
  const double crossed = std::max(1.0, kOverWithin * rough.bright_within);
  const bool is_rough = levels.noise > kLeastRoughRatio * levels.tissue;
  const bool is_fluid_speckled =
      rough.dark >= kLeastDarkRoughness * crossed && rough.dark <= kMostCutOffRatio * levels.fluid;
  const double level = is_fluid_speckled ? rough.bright_peak : levels.tissue;
  if (is_rough && crossed < levels.noise && crossed <= EchoLevels::kLeastLinearRatio * level)
    levels.noise = std::min(crossed, EchoLevels::kLeastLinearRatio * levels.tissue);
  // Of a small body most blocks are crossed by its border. Log-compressed, the fluid is as rough as the
  // tissue where black does not cut its speckle off.
  const bool is_small = count_from(means, bright) < kSmallShare * count_from(means, 0);
  const bool is_whole = levels.fluid >= kFullSpeckle * rough.dark && rough.dark > 0;
  if (is_small && is_whole && !levels.linear()) levels.noise = std::min(levels.noise, rough.dark);
  const double contrast = levels.tissue - levels.fluid;
  const bool stands_out = levels.linear() ? levels.tissue >= kLeastRatio * levels.fluid
                                          : contrast >= kLeastOverSpeckle * levels.noise;
  levels.known = contrast >= kLeastStep && stands_out;
  const bool is_speckle =
      levels.noise <= kMostSpeckleRatio * levels.tissue && rough.dark >= kLeastDarkRoughness * levels.noise;
  levels.flat = !levels.known && is_speckle;
  return levels;
}

/// The levels of a volume that seems flat: where a body is too small to be a class of its own, some blocks
/// are brighter than speckle can be.
EchoLevels levels_of_small_body(const Volume& volume, Blocks blocks, const EchoLevels& flat) {
  const Histogram means = blocks.means();
  const std::size_t beyond =
      bin_of(median_of(means, 0, means.size()) + kBeyondSpeckle * std::max(flat.noise, kLeastStep));
  for (std::size_t layer = 0; layer < kLayers; ++layer)
    if (lie_beyond(blocks, layer, beyond, kMostOfALayer)) blocks.counted[layer] = false;
  if (count_from(blocks.means(), beyond) < kLeastBlocks) return flat;
  const EchoLevels body = parted_levels(volume, blocks, beyond);
  return body.known ? body : flat;
}

/// The levels of a volume that has no surface below the layers that were left out. They are tissue, and not
/// reverberation, where they do not fade from the face on: as behind a thick wall, with fluid up to the end.
EchoLevels levels_of_near_tissue(const Volume& volume, Blocks blocks, const EchoLevels& rest) {
  const auto next =
      static_cast<std::size_t>(std::ranges::find(blocks.counted, true) - blocks.counted.begin());
  if (next < 2 || next == kLayers) return rest;
  const auto level_of = [&](std::size_t layer) {
    return median_of(blocks.layers[layer], 0, blocks.layers[layer].size());
  };
  const double fades = level_of(0) - level_of((next - 1) / 2);
  blocks.counted.fill(true);
  const EchoLevels all = parted_levels(volume, blocks, parted_at(blocks.means()));
  const bool is_tissue = fades < kMostFading * (all.tissue - all.fluid) && level_of(0) < kSaturated;
  return all.known && is_tissue ? all : rest;
}

}  // namespace

EchoLevels measured_levels(const Volume& volume) {
  if (volume.stamp().warnings.has(SweepWarning::kRings)) return {.flat = true};
  const Blocks blocks = blocks_of(volume);
  const std::size_t bright = parted_at(blocks.means());
  if (bright == 0) return levels_of_near_tissue(volume, blocks, {});
  EchoLevels levels = parted_levels(volume, blocks, bright);
  if (levels.flat) levels = levels_of_small_body(volume, blocks, levels);
  return levels.known ? levels : levels_of_near_tissue(volume, blocks, levels);
}

bool SteadyLevels::is_other(const EchoLevels& measured) const {
  if (measured.flat) return !mean_.known && !mean_.flat;
  return measured.known && (!mean_.known || differ(mean_, measured, kOtherChange));
}

void SteadyLevels::add(const EchoLevels& measured) {
  const bool stays_flat = measured.flat && mean_.flat;
  if (!measured.known && !stays_flat) {
    flat_volumes_ = measured.flat ? flat_volumes_ + 1 : 0;
    if (measured.flat && (!mean_.known || flat_volumes_ >= kFlatVolumes)) mean_ = in_force_ = measured;
    return;
  }
  flat_volumes_ = 0;
  if (stays_flat ? differ(mean_.noise, measured.noise, kOtherChange) : is_other(measured)) {
    mean_ = in_force_ = measured;
    return;
  }
  const auto follow = [](double& mean, double value) { mean += kShareOfNew * (value - mean); };
  follow(mean_.fluid, measured.fluid);
  follow(mean_.tissue, measured.tissue);
  follow(mean_.noise, measured.noise);
  if (differ(in_force_, mean_, kLeastChange)) in_force_ = mean_;
}

}  // namespace fanlight
