// SPDX-License-Identifier: Apache-2.0
// The CPU work for a volume, step by step: from the frame to the encoded picture.
#include <benchmark/benchmark.h>

#include <array>

#include "acquisition/assembly/sweep_check.hpp"
#include "acquisition/assembly/sweep_hysteresis.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "proto/exchange/volume_ring.hpp"
#include "renderer/parameters/angle_table.hpp"
#include "server/codec/h264_coder.hpp"
#include "server/codec/jpeg_coder.hpp"

namespace fanlight {
namespace {

std::unique_ptr<PhantomSource> phantom() {
  auto source = PhantomSource::create({.pace = PhantomSource::Pace::kUnpaced});
  if (!source) std::abort();
  return std::move(*source);
}

/// The first sweep of the phantom, with the size of R1.
Volume first_volume() {
  const auto source = phantom();
  Volume volume(source->description().geometry, source->description().frames_per_volume);
  while (!volume.full()) {
    const auto frame = source->next_frame({});
    source->read_pixels(volume.next_frame_pixels(), {});
    volume.add_frame(**frame);
  }
  volume.sort_by_angle();
  return volume;
}

void simulated_frame(benchmark::State& state) {
  const auto source = phantom();
  std::vector<std::uint8_t> pixels(source->description().geometry.frame_bytes());
  for (auto _ : state) {
    benchmark::DoNotOptimize(source->next_frame({}));
    source->read_pixels(pixels, {});
  }
}
BENCHMARK(simulated_frame)->Unit(benchmark::kMillisecond);

void volume_through_the_ring(benchmark::State& state) {
  Doorbell reader;
  Doorbell writer;
  VolumeRing ring({.geometry = {.columns = 8, .rows = 8}, .frame_capacity = 2},
                  {.reader_bell = reader, .writer_bell = writer});
  for (auto _ : state) {
    ring.begin();
    ring.publish();
    benchmark::DoNotOptimize(ring.take());
  }
}
BENCHMARK(volume_through_the_ring);

/// Computes the thumbnails of the frames of a volume, and compares them with those of the two volumes before.
void mismatch_of_a_volume(benchmark::State& state) {
  const auto source = phantom();
  const SourceDescription& description = source->description();
  Volume forward(description.geometry, description.frames_per_volume);
  Volume backward(description.geometry, description.frames_per_volume);
  SweepThumbnails thumbnails[2] = {SweepThumbnails(description.frames_per_volume),
                                   SweepThumbnails(description.frames_per_volume)};
  for (int sweep = 0; sweep < 2; ++sweep) {
    Volume& volume = sweep == 0 ? forward : backward;
    std::vector<FrameStamp> stamps;
    while (!volume.full()) {
      stamps.push_back(**source->next_frame({}));
      source->read_pixels(volume.next_frame_pixels(), {});
      volume.add_frame(stamps.back());
    }
    volume.sort_by_angle();
    thumbnails[sweep].take(volume, stamps);
  }
  AcquisitionCounters counters;
  SweepHysteresis mismatch(description.frames_per_volume, counters);
  for (auto _ : state) {
    mismatch.correct(forward, thumbnails[0]);
    mismatch.correct(backward, thumbnails[1]);
  }
  state.SetItemsProcessed(2 * state.iterations());
}
BENCHMARK(mismatch_of_a_volume)->Unit(benchmark::kMillisecond);

/// The check of a sweep without faults, with its thumbnails.
void check_of_a_volume(benchmark::State& state) {
  const Volume volume = first_volume();
  const std::vector<FrameStamp> stamps(volume.stamp().frames);
  SweepThumbnails thumbnails(volume.frame_capacity());
  SweepCheck check(volume.frame_capacity());
  for (auto _ : state) {
    thumbnails.take(volume, stamps);
    benchmark::DoNotOptimize(check.check(volume, thumbnails));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(check_of_a_volume)->Unit(benchmark::kMillisecond);

void angle_table_of_new_angles(benchmark::State& state) {
  const Volume volume = first_volume();
  std::vector<double> angles_rad(volume.angles_rad().begin(), volume.angles_rad().end());
  std::ranges::sort(angles_rad);
  std::vector<double> others_rad = angles_rad;
  for (double& angle_rad : others_rad) angle_rad *= 0.99;
  AngleTable table(angles_rad.front(), angles_rad.back(), volume.frame_capacity());
  for (auto _ : state) {
    table.update(others_rad);
    table.update(angles_rad);
  }
  state.SetItemsProcessed(2 * state.iterations());
}
BENCHMARK(angle_table_of_new_angles)->Unit(benchmark::kMillisecond);

/// A frame in grey.
Picture picture_of(const Volume& volume, std::uint32_t frame_index) {
  Picture picture{.stamp = {}, .width = 512, .height = 512, .rgba = {}};
  const auto frame = volume.frame_pixels(frame_index);
  for (std::size_t value = 0; value < std::size_t{4} * 512 * 512; ++value)
    picture.rgba.push_back(frame[value / 4]);
  return picture;
}

void picture_to_jpeg(benchmark::State& state) {
  const Volume volume = first_volume();
  const Picture picture = picture_of(volume, volume.stamp().frames / 2);
  JpegCoder encoder(85);
  for (auto _ : state) benchmark::DoNotOptimize(encoder.encode(pixels_of(picture), true));
}
BENCHMARK(picture_to_jpeg)->Unit(benchmark::kMillisecond);

void picture_to_h264(benchmark::State& state) {
  const Volume volume = first_volume();
  const std::array<Picture, 2> pictures = {picture_of(volume, volume.stamp().frames / 2),
                                           picture_of(volume, volume.stamp().frames / 2 + 1)};
  H264Coder encoder(4000, 15);
  std::size_t next = 0;
  for (auto _ : state) benchmark::DoNotOptimize(encoder.encode(pixels_of(pictures.at(++next % 2)), false));
}
BENCHMARK(picture_to_h264)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace fanlight

BENCHMARK_MAIN();
