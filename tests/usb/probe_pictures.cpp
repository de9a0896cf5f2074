// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/probe_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stop_token>
#include <utility>

#include "proto/base/crc32c.hpp"

namespace fanlight::test {

namespace {

constexpr double kMostSceneRateHz = 1000;

}  // namespace

Result<std::unique_ptr<ProbePictures>> ProbePictures::create(const Config& config) {
  auto source = PhantomSource::create({.frame_rate_hz = std::min(config.frame_rate_hz, kMostSceneRateHz),
                                       .frames_per_volume = config.frames_per_volume,
                                       .columns = config.columns,
                                       .rows = config.rows,
                                       .sweep_deg = config.sweep_deg,
                                       .seed = config.seed,
                                       .pace = PhantomSource::Pace::kUnpaced});
  if (!source) return source.error();
  return std::unique_ptr<ProbePictures>(new ProbePictures(config, std::move(*source)));
}

ProbePictures::ProbePictures(const Config& config, std::unique_ptr<PhantomSource> source)
    : config_(config),
      source_(std::move(source)),
      kept_(config.prepared ? 2 * std::size_t{config.frames_per_volume} : 1) {}

ProbePictures::Place ProbePictures::place(std::uint64_t picture) const {
  const std::uint32_t frames = config_.frames_per_volume;
  Place place{.sweep = picture / frames, .index = static_cast<std::uint32_t>(picture % frames)};
  place.direction = place.sweep % 2 == 0 ? SweepDirection::kForward : SweepDirection::kBackward;
  const bool forward = place.direction == SweepDirection::kForward;
  const std::uint32_t along = forward ? place.index : frames - 1 - place.index;
  place.angle_deg =
      std::lerp(-config_.sweep_deg / 2, config_.sweep_deg / 2, static_cast<double>(along) / (frames - 1));
  return place;
}

ProbePictures::Picture ProbePictures::show(std::uint64_t picture, std::uint32_t rows) {
  Kept& kept = kept_[config_.prepared ? picture % kept_.size() : 0];
  const bool redraw = !config_.prepared || kept.pixels.empty();
  if (redraw) draw(picture, kept.pixels);
  const auto pixels = std::span<const std::uint8_t>(kept.pixels).first(std::size_t{config_.columns} * rows);
  if (redraw || kept.rows != rows) {
    kept.rows = rows;
    kept.crc32c = crc32c(pixels);
  }
  return {pixels, kept.crc32c};
}

void ProbePictures::prepare(std::uint32_t rows) {
  if (!config_.prepared) return;
  for (std::size_t picture = 0; picture < kept_.size(); ++picture) show(picture, rows);
}

void ProbePictures::draw(std::uint64_t picture, std::vector<std::uint8_t>& pixels) {
  pixels.resize(geometry().frame_bytes());
  for (;;) {
    const auto stamp = source_->next_frame(std::stop_token{});
    // An unpaced source without an end always has a next frame. An earlier frame would mean that pictures
    // were requested backward.
    if (!stamp || !*stamp || (*stamp)->sequence > picture) std::abort();
    if ((*stamp)->sequence == picture) break;
  }
  source_->read_pixels(pixels, std::stop_token{});
}

}  // namespace fanlight::test
