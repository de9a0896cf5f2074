// SPDX-License-Identifier: Apache-2.0
#include "tests/usb_vm/reader_fixture.hpp"

#include <chrono>
#include <stdexcept>
#include <thread>

#include "proto/base/clock.hpp"

namespace fanlight::test {

ReaderFixture::ReaderFixture() {
  auto source = UsbSource::create({.address = {.vendor = 0x1209, .product = 1}}, link_);
  if (!source) throw std::runtime_error(source.error().message);
  source_ = *std::move(source);
  ring_ = std::make_unique<VolumeRing>(
      VolumeRing::Config{.geometry = source_->description().geometry,
                         .frame_capacity = source_->description().frames_per_volume,
                         .largest_frame_bytes = source_->description().largest_frame_bytes},
      VolumeRing::Dependencies{.reader_bell = reader_bell_, .writer_bell = writer_bell_});
  acquisition_.emplace(AcquisitionThread::Dependencies{.source = *source_,
                                                       .ring = *ring_,
                                                       .writer_bell = writer_bell_,
                                                       .counters = frames_,
                                                       .ended_bell = server_bell_});
}

const ProbeStatus& ReaderFixture::status() {
  if (const ProbeStatus* newest = link_.status.newest()) status_ = *newest;
  return status_;
}

std::string ReaderFixture::order(const probe::Settings& settings) {
  link_.orders.draft() = {.number = ++orders_, .settings = settings};
  link_.orders.publish();
  await([this] { return status().order_answered == orders_; }, "the order was not answered");
  return status_.refusal;
}

void ReaderFixture::next_volume() {
  const std::uint64_t before = ring_->counters().volumes_published.value();
  await([&] { return ring_->counters().volumes_published.value() > before; }, "no volume came");
}

void ReaderFixture::next_volume(const std::function<bool(const Volume&)>& looks) {
  await(
      [&] {
        const VolumeRing::Lease lease = ring_->take();
        return lease && looks(*lease);
      },
      "no such volume came");
}

void await(const std::function<bool()>& holds, const std::string& otherwise) {
  constexpr std::int64_t kMostNs = 20'000'000'000;
  const std::int64_t end_ns = now_ns() + kMostNs;
  while (!holds()) {
    if (now_ns() > end_ns) throw std::runtime_error(otherwise);
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
}

}  // namespace fanlight::test
