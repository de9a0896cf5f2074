// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/usb/usb_source.hpp"

namespace fanlight::test {

/// The acquisition as `fanlight serve` connects it: the source, the acquisition thread and the ring. The
/// owner replaces the renderer and the server. One thread.
class ReaderFixture {
 public:
  /// Waits for the probe 1209:0001 and starts reading. Throws std::runtime_error with the error's message.
  ReaderFixture();
  /// Stops reading; the counters remain.
  void stop() { acquisition_.reset(); }

  const SourceDescription& description() const { return source_->description(); }
  VolumeRing& ring() { return *ring_; }
  const AcquisitionCounters& frames() const { return frames_; }
  const ProbeCounters& counters() const { return link_.counters; }
  /// The last published status.
  const ProbeStatus& status();

  /// Orders settings and waits for the answer: empty, or the reason of the refusal.
  std::string order(const probe::Settings& settings);

  /// Waits for a volume that is published after this call. Throws where none arrives within 20 s.
  void next_volume();
  /// Takes volumes out of the ring until one satisfies `looks`. Throws likewise.
  void next_volume(const std::function<bool(const Volume&)>& looks);

 private:
  Doorbell reader_bell_;
  Doorbell writer_bell_;
  Doorbell server_bell_;
  ProbeLink link_{writer_bell_, server_bell_};
  ProbeStatus status_;
  std::uint64_t orders_ = 0;
  AcquisitionCounters frames_;
  std::unique_ptr<UsbSource> source_;
  std::unique_ptr<VolumeRing> ring_;
  std::optional<AcquisitionThread> acquisition_;
};

/// Polls every 200 us until `holds`. Throws with the text `otherwise` after 20 s. Polls, because counters
/// have no notification.
void await(const std::function<bool()>& holds, const std::string& otherwise);

}  // namespace fanlight::test
