// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace fanlight {

// Decisions of a UsbSource about a probe that fails. Pure logic: time is a parameter, on the clock of
// fanlight::now_ns(). One thread.

/// Detects a probe that stopped sending bytes, or sends bytes without a frame among them.
class SilenceWatch {
 public:
  /// The protocol asks for at least one frame a second.
  static constexpr std::int64_t kSilenceNs = 1'500'000'000;
  /// Time between two calls of `polled` above which the caller is assumed to have been blocked elsewhere (it
  /// waited for room in the ring). Far above the delays of a busy machine.
  static constexpr std::int64_t kPauseNs = 200'000'000;

  void stream_started(std::int64_t at_ns) { last_bytes_ns_ = last_frame_ns_ = at_ns; }
  /// To be called before each look at the reads. After a pause of the caller, silence is measured from now
  /// on: the probe could not be heard.
  void polled(std::int64_t at_ns) {
    if (at_ns - std::exchange(last_poll_ns_, at_ns) > kPauseNs) stream_started(at_ns);
  }
  void bytes_received(std::int64_t at_ns) { last_bytes_ns_ = at_ns; }
  void frame_received(std::int64_t at_ns) { last_frame_ns_ = at_ns; }

  bool without_bytes(std::int64_t at_ns) const { return at_ns - last_bytes_ns_ >= kSilenceNs; }
  bool without_frames(std::int64_t at_ns) const { return at_ns - last_frame_ns_ > kSilenceNs; }

 private:
  std::int64_t last_poll_ns_ = 0;
  std::int64_t last_bytes_ns_ = 0;
  std::int64_t last_frame_ns_ = 0;
};

/// Counts repairs and restarts of a stream without a whole frame in between.
class RepairLimit {
 public:
  static constexpr std::uint32_t kMostRepairs = 3;

  /// False where this one is above the limit: the probe is to be reset.
  bool allows_repair() { return ++repairs_ <= kMostRepairs; }
  void frame_completed() { repairs_ = 0; }
  void probe_opened() { repairs_ = 0; }

 private:
  std::uint32_t repairs_ = 0;
};

/// Delay until the next search for a probe that was lost. A probe that is repeatedly lost before its first
/// frame is searched for after twice the time, and reset with every third such loss.
class ReturnBackoff {
 public:
  /// Where no udev runs, only a new libusb context finds devices plugged in since: it is made this often.
  static constexpr std::int64_t kSearchNs = 250'000'000;
  static constexpr std::uint32_t kMostDoublings = 4;  ///< up to 4 s
  static constexpr std::uint32_t kResetAfter = 3;

  struct Decision {
    bool reset_probe = false;
    std::int64_t search_delay_ns = kSearchNs;
  };

  /// `had_frames`: a frame was received since the probe was opened.
  Decision probe_lost(bool had_frames) {
    fruitless_ = had_frames ? 0 : fruitless_ + 1;
    return {.reset_probe = fruitless_ > 0 && fruitless_ % kResetAfter == 0,
            .search_delay_ns = kSearchNs << std::min(fruitless_, kMostDoublings)};
  }

 private:
  std::uint32_t fruitless_ = 0;  // losses in a row without a frame
};

}  // namespace fanlight
