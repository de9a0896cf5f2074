// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/acquisition_fixture.hpp"

#include <stdexcept>
#include <thread>

#include "proto/base/clock.hpp"

namespace fanlight::test {

AcquisitionFixture::AcquisitionFixture(const Config& config) : bus_(config.udev) {
  auto probe = UsbfsProbe::create(bus_, {.model = config.model, .faults = config.faults});
  if (!probe) throw std::runtime_error(probe.error().message);
  probe_ = *std::move(probe);
  probe_->plug();
  auto source =
      UsbSource::create({.address = {.vendor = 0x1209, .product = 1}, .reads = config.reads}, link_);
  if (!source) throw std::runtime_error(source.error().message);
  source_ = *std::move(source);
  ring_ = std::make_unique<VolumeRing>(
      VolumeRing::Config{.geometry = source_->description().geometry,
                         .frame_capacity = source_->description().frames_per_volume,
                         .policy = config.policy,
                         .largest_frame_bytes = source_->description().largest_frame_bytes},
      VolumeRing::Dependencies{.reader_bell = reader_bell_, .writer_bell = writer_bell_});
}

void AcquisitionFixture::start() {
  acquisition_.emplace(AcquisitionThread::Dependencies{.source = *source_,
                                                       .ring = *ring_,
                                                       .writer_bell = writer_bell_,
                                                       .counters = frames_,
                                                       .ended_bell = server_bell_});
}

bool wait_until(const std::function<bool()>& holds, double most_s) {
  const std::int64_t end_ns = now_ns() + static_cast<std::int64_t>(most_s * 1e9);
  while (!holds()) {
    if (now_ns() > end_ns) return false;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  return true;
}

}  // namespace fanlight::test
