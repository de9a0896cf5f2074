#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/usb_source.hpp"
#include "tests/usb/usbfs_probe.hpp"

namespace fanlight::test {

/// An emulated probe, and of Fanlight what reads it: the source, the acquisition thread and the ring, with
/// nobody who renders. The probe is plugged in. Made and used by one thread.
class LiveHouse {
 public:
  struct Config {
    ProbeModel::Config model;
    std::string faults;  ///< FaultScript
    EmulatedBus::Udev udev = EmulatedBus::Udev::kOn;
    TransferQueue::Config reads;
    RingPolicy policy = RingPolicy::kNewestWins;
  };
  /// Throws std::runtime_error with the sentence of what went wrong.
  explicit LiveHouse(const Config& config);

  UsbfsProbe& probe() { return *probe_; }
  const SourceDescription& description() const { return source_->description(); }
  VolumeRing& ring() { return *ring_; }
  Doorbell& reader_bell() { return reader_bell_; }  ///< of who takes volumes out of the ring
  const AcquisitionCounters& frames() const { return frames_; }
  const ProbeCounters& counters() const { return link_.counters; }

  /// Begins to read; before, the ring may be given a reader.
  void start();
  /// Ends the reading; the counters stay.
  void stop() { acquisition_.reset(); }

 private:
  EmulatedBus bus_;
  std::unique_ptr<UsbfsProbe> probe_;
  Doorbell reader_bell_;
  Doorbell writer_bell_;
  Doorbell server_bell_;
  ProbeLink link_{writer_bell_, server_bell_};
  AcquisitionCounters frames_;
  std::unique_ptr<UsbSource> source_;
  std::unique_ptr<VolumeRing> ring_;
  std::optional<AcquisitionThread> acquisition_;
};

/// Waits until it holds, looking every 200 us; false after so many seconds.
bool wait_until(const std::function<bool()>& holds, double most_s = 30);

}  // namespace fanlight::test
