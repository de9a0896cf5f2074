#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/usb_source.hpp"

namespace fanlight::test {

/// Of Fanlight what reads a probe, wired as `fanlight serve` does it: the source, the acquisition thread and
/// the ring, with the one who made it in the renderer's and the server's place. One thread.
class ReadingHouse {
 public:
  /// Waits for the probe 1209:0001 and begins to read. Throws std::runtime_error with the sentence of what
  /// went wrong.
  ReadingHouse();
  /// Ends the reading; the counters stay.
  void stop() { acquisition_.reset(); }

  const SourceDescription& description() const { return source_->description(); }
  VolumeRing& ring() { return *ring_; }
  const AcquisitionCounters& frames() const { return frames_; }
  const ProbeCounters& counters() const { return link_.counters; }
  /// As last published.
  const ProbeStatus& status();

  /// Asks for settings, and waits for the answer: empty, or why they were refused.
  std::string order(const probe::Settings& settings);

  /// Waits for a volume that is published after this call. Throws where none comes within 20 s.
  void next_volume();
  /// Waits for a volume that looks like this, taking it out of the ring. Throws likewise.
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

/// Waits until it holds, looking every 200 us. Throws with that text where it does not within 20 s.
void await(const std::function<bool()>& holds, const std::string& otherwise);

}  // namespace fanlight::test
