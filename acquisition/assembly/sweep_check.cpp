// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/sweep_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

using Blocks = SweepThumbnails::Blocks;

constexpr std::uint32_t kFewestCopies = 3;
constexpr double kLeastTexture = 0.02;        // of the pixels: different from the one before
constexpr double kSparseRad = radians(5.05);  // a step of 5 deg is not more than 5 deg
constexpr double kLeastStepRad = radians(0.01);
constexpr double kMostBlank = 0.25;            // of the frames, at the ends of a sweep
constexpr std::uint32_t kFramesCompared = 24;  // of a sweep, where each is compared with many
constexpr std::uint32_t kNeighbourhood = 3;    // frames; what is nearer resembles by nature
// Of the squared difference to the neighbours. A frame whose true neighbours stand elsewhere differs less by
// far; where the scene changes little, the minimum over many frames of speckle is some 0.75.
constexpr float kMostOfNeighbours = 0.55F;
constexpr float kMostOfSame = 0.6F;  // likewise, of a mirrored sweep
// A beam is wider than the frames are apart, so that an edge in the body appears over several frames.
// Measured: at most 1.16 times what lies beside, in the simulated probes' sweeps and a real head; 1.4 to 3.2
// with a slip of 4 to 6 deg.
constexpr float kJumpOverBeside = 1.35F;
constexpr double kMostOfSpan =
    0.75;  // a hand moves the probe unsteadily: a step of the angle explains that change
constexpr float kLeastOfOther = 0.3F;  // variance of the frames on both sides of a jump
constexpr float kLeastJump = 4;        // grey levels squared, mean over the blocks

float squared_difference(const Blocks& a, const Blocks& b) {
  float sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum / static_cast<float>(a.size());
}

/// Over the blocks of a frame.
float variance(const Blocks& blocks) {
  float sum = 0;
  float squares = 0;
  for (const float level : blocks) {
    sum += level;
    squares += level * level;
  }
  const auto count = static_cast<float>(blocks.size());
  return std::max(0.0F, squares / count - (sum / count) * (sum / count));
}

bool has_one_level(std::span<const std::uint8_t> pixels) {
  return std::ranges::all_of(pixels, [first = pixels.front()](std::uint8_t level) { return level == first; });
}

/// Whether the frame has the noise of a receiver. What is drawn without any may repeat itself.
bool is_textured(std::span<const std::uint8_t> pixels) {
  std::size_t different = 0;
  for (std::size_t i = 1; i < pixels.size(); ++i) different += pixels[i] != pixels[i - 1] ? 1 : 0;
  return static_cast<double>(different) > kLeastTexture * static_cast<double>(pixels.size());
}

void compare_pixels(const Volume& volume, SweepWarnings& warnings) {
  const auto order = volume.by_angle();
  std::uint32_t blank = 0;
  std::uint32_t blank_run = 0;  // at the end so far
  std::uint32_t blank_between = 0;
  std::uint32_t copies = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto pixels = volume.frame_pixels(order[i]);
    if (has_one_level(pixels)) {
      ++blank;
      ++blank_run;
      continue;
    }
    if (blank < i) blank_between += blank_run;
    blank_run = 0;
    if (i == 0) continue;
    const double step_rad = volume.angles_rad()[order[i]] - volume.angles_rad()[order[i - 1]];
    if (step_rad > kLeastStepRad && std::ranges::equal(pixels, volume.frame_pixels(order[i - 1])) &&
        is_textured(pixels))
      ++copies;
  }
  // The ends of a sweep may lie beside the body.
  if (blank_between > 0 || blank > kMostBlank * static_cast<double>(order.size()))
    warnings.add(SweepWarning::kBlank);
  if (copies >= kFewestCopies || copies + 1 == order.size()) warnings.add(SweepWarning::kCopies);
}

bool is_sparse(const SweepThumbnails& sweep) {
  double widest_rad = 0;
  for (std::uint32_t i = 1; i < sweep.frames(); ++i)
    widest_rad = std::max(widest_rad, sweep.angle_rad(i) - sweep.angle_rad(i - 1));
  return widest_rad > kSparseRad;
}

/// Most of some frames differ much less from a distant frame than from their neighbours.
bool is_out_of_order(const SweepThumbnails& sweep) {
  const std::uint32_t frames = sweep.frames();
  if (frames < 3 * kNeighbourhood) return false;
  const std::uint32_t compared = std::min(kFramesCompared, frames - 2);
  std::uint32_t misplaced = 0;
  for (std::uint32_t n = 0; n < compared; ++n) {
    const std::uint32_t i = 1 + n * (frames - 2) / compared;
    const Blocks& blocks = sweep.blocks(i);
    const float beside = std::min(squared_difference(blocks, sweep.blocks(i - 1)),
                                  squared_difference(blocks, sweep.blocks(i + 1)));
    float least = std::numeric_limits<float>::max();
    for (std::uint32_t j = 0; j < frames; ++j) {
      if (j + kNeighbourhood > i && i + kNeighbourhood > j) continue;
      least = std::min(least, squared_difference(blocks, sweep.blocks(j)));
    }
    if (beside > kLeastJump && least < kMostOfNeighbours * beside) ++misplaced;
  }
  return 2 * misplaced > compared;
}

/// The frame of a sweep whose angle is nearest.
std::uint32_t nearest(const SweepThumbnails& sweep, double angle_rad) {
  std::uint32_t best = 0;
  for (std::uint32_t i = 1; i < sweep.frames(); ++i)
    if (std::abs(sweep.angle_rad(i) - angle_rad) < std::abs(sweep.angle_rad(best) - angle_rad)) best = i;
  return best;
}

bool is_mirrored(const SweepThumbnails& sweep, const SweepThumbnails& before) {
  if (before.empty() || !(before.geometry() == sweep.geometry())) return false;
  const std::uint32_t compared = std::min(kFramesCompared, sweep.frames());
  const double both_ends_rad = sweep.angle_rad(0) + sweep.angle_rad(sweep.frames() - 1);
  float same = 0;
  float mirrored = 0;
  for (std::uint32_t n = 0; n < compared; ++n) {
    const std::uint32_t i = n * sweep.frames() / compared;
    const double angle_rad = sweep.angle_rad(i);
    same += squared_difference(sweep.blocks(i), before.blocks(nearest(before, angle_rad)));
    mirrored +=
        squared_difference(sweep.blocks(i), before.blocks(nearest(before, both_ends_rad - angle_rad)));
  }
  return mirrored < kMostOfSame * same;
}

}  // namespace

SweepCheck::SweepCheck(std::uint32_t frame_capacity) : before_(frame_capacity), steps_(frame_capacity) {}

SweepWarnings SweepCheck::check(const Volume& volume, const SweepThumbnails& thumbnails) {
  SweepWarnings warnings;
  compare_pixels(volume, warnings);
  const bool is_whole = warnings.empty();  // else its frames say nothing about their order
  if (is_sparse(thumbnails)) warnings.add(SweepWarning::kSparse);
  if (rings_.shows_rings(volume)) warnings.add(SweepWarning::kRings);
  if (!is_whole || warnings.has(SweepWarning::kRings)) {
    forget_volumes();
    return warnings;
  }
  if (is_out_of_order(thumbnails)) {
    warnings.add(SweepWarning::kOutOfOrder);
  } else if (jumps(thumbnails)) {
    warnings.add(SweepWarning::kJump);
  }
  // A body that crosses the middle while the probe is placed looks mirrored once.
  const bool mirrored = is_mirrored(thumbnails, before_);
  if (mirrored && was_mirrored_) warnings.add(SweepWarning::kMirrored);
  was_mirrored_ = mirrored;
  before_ = thumbnails;
  return warnings;
}

/// Between two neighbours there is more change than over twice their distance on either side.
bool SweepCheck::jumps(const SweepThumbnails& sweep) {
  constexpr std::uint32_t kSpan = 2;
  const std::uint32_t frames = sweep.frames();
  if (frames < 6 * kSpan) return false;
  for (std::uint32_t i = 0; i + 1 < frames; ++i)
    steps_[i] = squared_difference(sweep.blocks(i), sweep.blocks(i + 1));
  const auto all = std::span(steps_).first(frames - 1);
  std::ranges::nth_element(all, all.begin() + (frames - 1) / 2);
  const float usual = all[(frames - 1) / 2];
  // The first and last frames may lie at the border of what is seen.
  for (std::uint32_t i = kSpan; i + kSpan + 1 < frames; ++i) {
    const auto apart_rad = [&](std::uint32_t from, std::uint32_t to) {
      return sweep.angle_rad(to) - sweep.angle_rad(from);
    };
    const double span_rad = std::min(apart_rad(i - kSpan, i), apart_rad(i + 1, i + 1 + kSpan));
    if (apart_rad(i, i + 1) > kMostOfSpan * span_rad) continue;
    // Where contact is lost, or the body ends, one side shows little.
    const float here = variance(sweep.blocks(i));
    const float next = variance(sweep.blocks(i + 1));
    if (std::min(here, next) < kLeastOfOther * std::max(here, next)) continue;
    const float step = squared_difference(sweep.blocks(i), sweep.blocks(i + 1));
    const float beside = std::max(squared_difference(sweep.blocks(i - kSpan), sweep.blocks(i)),
                                  squared_difference(sweep.blocks(i + 1), sweep.blocks(i + 1 + kSpan)));
    if (step > kLeastJump && step > kJumpOverBeside * std::max(beside, usual)) return true;
  }
  return false;
}

}  // namespace fanlight
