// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "acquisition/usb/usb_source.hpp"
#include "tests/usb/usbfs_probe.hpp"

namespace fanlight::test {

/// A UsbSource on an emulated bus with one emulated probe. The test replaces the acquisition thread.
struct SourceRig {
  /// One frame from the source.
  struct Frame {
    FrameStamp stamp;
    FrameFault fault = FrameFault::kNone;
    std::vector<std::uint8_t> pixels;
  };

  /// 64 x 64 pixels at 200 frames a second, 10 a volume: a sweep takes 50 ms.
  static ProbeModel::Config small() {
    return {.frame_rate_hz = 200, .frames_per_volume = 10, .columns = 64, .rows = 64, .room_frames = 1000};
  }

  explicit SourceRig(const std::string& faults = "", const ProbeModel::Config& model = small(),
                     EmulatedBus::Udev udev = EmulatedBus::Udev::kOn)
      : bus(udev), probe(UsbfsProbe::create(bus, {.model = model, .faults = faults}).value()) {
    probe->plug();
  }

  Result<void> open(const UsbSource::Settings& settings = {}, const std::string& serial = "",
                    double wait_s = 5) {
    auto made = UsbSource::create({.address = {.vendor = 0x1209, .product = 1, .serial = serial},
                                   .settings = settings,
                                   .wait_s = wait_s,
                                   .reads = {.transfers = 16, .transfer_bytes = 16 << 10}},
                                  link);
    if (!made) return made.error();
    source = *std::move(made);
    return {};
  }

  /// Blocks until the next frame.
  Frame next() {
    Frame frame;
    auto stamp = source->next_frame(stop.get_token());
    if (!stamp || !*stamp) {
      ADD_FAILURE() << "the source ended";
      return frame;
    }
    frame.stamp = **stamp;
    frame.fault = source->known_fault();
    if (frame.fault == FrameFault::kNone) {
      frame.pixels.resize(source->description().geometry.frame_bytes());
      frame.fault = source->read_pixels(frame.pixels, stop.get_token());
    }
    return frame;
  }

  std::vector<Frame> next(std::size_t count) {
    std::vector<Frame> frames;
    while (frames.size() < count && !testing::Test::HasFailure()) frames.push_back(next());
    return frames;
  }

  /// Reads until `holds`, at most `most` frames.
  template <typename Holds>
  std::vector<Frame> next_until(Holds holds, std::size_t most = 2000) {
    std::vector<Frame> frames;
    while (!holds() && !testing::Test::HasFailure()) {
      frames.push_back(next());
      if (frames.size() == most) ADD_FAILURE() << "it did not come about within " << most << " frames";
    }
    return frames;
  }

  const ProbeCounters& counters() const { return link.counters; }

  /// The last published status.
  const ProbeStatus& status() {
    if (const ProbeStatus* newest = link.status.newest()) last_status = *newest;
    return last_status;
  }

  EmulatedBus bus;
  std::unique_ptr<UsbfsProbe> probe;
  Doorbell acquisition_bell;
  Doorbell server_bell;
  ProbeLink link{acquisition_bell, server_bell};
  std::stop_source stop;
  std::unique_ptr<UsbSource> source;
  ProbeStatus last_status;
};

}  // namespace fanlight::test
