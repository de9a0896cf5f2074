// SPDX-License-Identifier: Apache-2.0
#include "acquisition/phantom/frame_speckle.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fanlight {

namespace {

constexpr std::uint32_t kTileSide = SpeckleTile::kSide;
// A slice with less than this part of the middle's amplitude is left out.
constexpr float kLeastWeight = 0.1F;

}  // namespace

FrameSpeckle::FrameSpeckle(std::uint32_t columns) : factors_(columns, kOne) {}

FrameSpeckle::FrameSpeckle(std::uint64_t seed, std::uint32_t columns, std::vector<float> deviations)
    : tile_(seed),
      seed_(seed),
      deviations_(std::move(deviations)),
      real_(columns),
      imaginary_(columns),
      factors_(columns, kOne) {}

void FrameSpeckle::set_place(const Place& place) {
  const auto nearest = static_cast<std::int64_t>(std::lround(place.frame));
  for (int slice = -kReach; slice <= kReach; ++slice) {
    const auto index = static_cast<std::uint64_t>(nearest + slice);
    const std::uint64_t bits = mixed_bits(seed_ + mixed_bits(mixed_bits(place.sweep + 1) + index));
    slices_[slice + kReach] = {
        .row = static_cast<std::uint32_t>(bits >> 32),
        .column = static_cast<std::uint32_t>(bits) % kTileSide,
        .away = static_cast<float>(static_cast<double>(nearest + slice) - place.frame)};
  }
}

std::span<const std::uint8_t> FrameSpeckle::row(std::uint32_t row) {
  if (!tile_) return factors_;
  std::ranges::fill(real_, 0.0F);
  std::ranges::fill(imaginary_, 0.0F);
  // The amplitude's variance is twice that of the power.
  const float deviation = std::clamp(deviations_[row], 0.05F, kMostDeviation);
  float squares = 0;
  for (int slice = 0; slice <= 2 * kReach; ++slice) {
    const float away = slices_[slice].away / deviation;
    const float weight = std::exp(-0.25F * away * away);
    if (slice != kReach && weight < kLeastWeight) continue;
    add(slices_[slice], row, weight);
    squares += weight * weight;
  }
  const float scale = static_cast<float>(kOne) / (SpeckleTile::kMean * std::sqrt(squares));
  // Local copies: the compiler must assume that a written factor aliases the members.
  const std::span<const float> real = real_;
  const std::span<const float> imaginary = imaginary_;
  const std::span<std::uint8_t> factors = factors_;
  for (std::size_t column = 0; column < factors.size(); ++column) {
    const float magnitude = std::sqrt(real[column] * real[column] + imaginary[column] * imaginary[column]);
    factors[column] = static_cast<std::uint8_t>(std::min(255.0F, magnitude * scale + 0.5F));
  }
  return factors_;
}

void FrameSpeckle::add(const Slice& slice, std::uint32_t row, float weight) {
  const std::int16_t* const real = tile_->real(slice.row + row);
  const std::int16_t* const imaginary = tile_->imaginary(slice.row + row);
  const std::size_t columns = factors_.size();
  std::size_t from = slice.column;
  for (std::size_t column = 0; column < columns; from = 0) {
    const std::size_t count = std::min(columns - column, kTileSide - from);
    for (std::size_t i = 0; i < count; ++i) {
      real_[column + i] += weight * static_cast<float>(real[from + i]);
      imaginary_[column + i] += weight * static_cast<float>(imaginary[from + i]);
    }
    column += count;
  }
}

}  // namespace fanlight
