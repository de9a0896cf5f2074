// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/igtl/igtl_source.hpp"
#include "acquisition/sequence/plus_fields.hpp"
#include "proto/base/clock.hpp"
#include "proto/exchange/probe_link.hpp"
#include "tests/igtl/fake_scanner.hpp"
#include "tests/igtl/sent_messages.hpp"

// A scanner that a test plays, and the source that reads it.
namespace fanlight::test::igtl_source_tests {

inline constexpr std::uint32_t kFrames = 20;  // a sweep
inline constexpr std::uint16_t kColumns = 16;
inline constexpr std::uint16_t kRows = 12;
inline constexpr std::uint64_t kBeganMs = 1'700'000'000'000;

inline const RecordingFacts& facts() {
  static const RecordingFacts known{.source = "phantom:",
                                    .geometry = {.columns = kColumns,
                                                 .rows = kRows,
                                                 .pixel_width_mm = 0.5,
                                                 .pixel_height_mm = 0.5,
                                                 .face_column = 7.5,
                                                 .motor_radius_mm = 30},
                                    .frames_per_volume = kFrames,
                                    .usual_frames = kFrames,
                                    .first_angle_rad = radians(-20),
                                    .last_angle_rad = radians(20),
                                    .begun_utc_s = 1'700'000'000};
  return known;
}

/// An image as a Fanlight sends it.
inline SentImage of_fanlight(std::uint32_t index) {
  SentImage sent{.grey = static_cast<std::uint8_t>(index), .time_ms = kBeganMs + 10 * index};
  sent.metadata = fanlight_fields(facts());
  const RecordedFrame frame{
      .stamp = {.sequence = index,
                .volume_index = index / kFrames,
                .frame_index = index % kFrames,
                .frames_in_sweep = kFrames,
                .direction = index / kFrames % 2 == 0 ? SweepDirection::kForward : SweepDirection::kBackward,
                .angle_rad = radians(angle_deg(index, kFrames))}};
  for (const auto& field : frame_fields(facts(), frame)) sent.metadata.push_back(field);
  return sent;
}

/// An image of a PlusServer whose transforms move it.
inline SentImage of_plus(std::uint32_t index) {
  SentImage sent{.time_ms = kBeganMs + 40 * index};
  sent.pose = SentFan{}.pose(0);
  sent.pose.first_mm[1] += 30;  // the axis is the origin
  return sent;
}

inline Bytes transform_of_plus(std::uint32_t index) {
  const double angle = radians(angle_deg(index, kFrames));
  return transform_message(
      "ProbeToTracker", kBeganMs + 40 * index,
      {.j_mm = {0, std::cos(angle), std::sin(angle)}, .k_mm = {0, -std::sin(angle), std::cos(angle)}});
}

struct Frame {
  FrameStamp stamp;
  FrameFault fault = FrameFault::kNone;
  Bytes pixels;
};

/// A scanner and the source that reads it.
class Rig {
 public:
  /// Opens the source while `first` is sent.
  bool open(const std::vector<Bytes>& first, const std::string& options = "",
            IgtlSource::Config config = {}) {
    config.address = *IgtlAddress::parse(scanner.place() + options);
    std::thread server([&] {
      if (!scanner.accept()) return;
      for (const Bytes& message : first)
        if (!scanner.send(message)) return;
    });
    auto opened = IgtlSource::create(config, link);
    server.join();
    if (!opened) error = opened.error();
    if (opened) source = *std::move(opened);
    return source != nullptr;
  }

  /// The next frames; fewer where none comes for two seconds.
  std::vector<Frame> next(std::size_t count) {
    std::vector<Frame> frames;
    std::stop_source stop;
    std::atomic<std::int64_t> last_ns = now_ns();
    std::jthread watch([&](const std::stop_token& ended) {
      while (!ended.stop_requested() && now_ns() - last_ns < 2'000'000'000)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      stop.request_stop();
    });
    while (frames.size() < count) {
      auto stamp = source->next_frame(stop.get_token());
      if (!stamp) error = stamp.error();
      if (!stamp || !*stamp) break;
      last_ns = now_ns();
      Frame frame{.stamp = **stamp, .fault = source->known_fault()};
      if (frame.fault == FrameFault::kNone) {
        frame.pixels.resize(source->description().geometry.frame_bytes());
        frame.fault = source->read_pixels(frame.pixels, stop.get_token());
      }
      frames.push_back(std::move(frame));
    }
    return frames;
  }

  const IgtlCounters& counters() const { return link.igtl; }
  bool sum_holds() const {
    const IgtlCounters& c = counters();
    return c.messages_received.value() == c.messages_used.value() + c.messages_ignored.value() +
                                              c.messages_damaged.value() + c.messages_malformed.value() +
                                              c.messages_too_long.value();
  }
  ProbeStatus status() {
    if (const ProbeStatus* const newest = link.status.newest()) status_ = *newest;
    return status_;
  }

  FakeScanner scanner;
  Doorbell acquisition_bell;
  Doorbell server_bell;
  ProbeLink link{acquisition_bell, server_bell};
  std::unique_ptr<IgtlSource> source;
  Error error;

 private:
  ProbeStatus status_;
};

}  // namespace fanlight::test::igtl_source_tests
