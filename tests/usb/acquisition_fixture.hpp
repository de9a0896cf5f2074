// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/usb/usb_source.hpp"
#include "tests/usb/usbfs_probe.hpp"

namespace fanlight::test {

/// An emulated probe and the acquisition that reads it: the source, the acquisition thread and the ring,
/// without a renderer. The probe is plugged in. Used by one thread.
class AcquisitionFixture {
 public:
  struct Config {
    ProbeModel::Config model;
    std::string faults;  ///< FaultScript
    EmulatedBus::Udev udev = EmulatedBus::Udev::kOn;
    TransferQueue::Config reads;
    RingPolicy policy = RingPolicy::kNewestWins;
  };
  /// Throws std::runtime_error with the error's message.
  explicit AcquisitionFixture(const Config& config);

  UsbfsProbe& probe() { return *probe_; }
  const SourceDescription& description() const { return source_->description(); }
  VolumeRing& ring() { return *ring_; }
  Doorbell& reader_bell() { return reader_bell_; }  ///< bell of the ring's reader
  const AcquisitionCounters& frames() const { return frames_; }
  const ProbeCounters& counters() const { return link_.counters; }

  /// Starts reading. A test may attach a reader to the ring before.
  void start();
  /// Stops reading; the counters remain.
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

/// Polls every 200 us until `holds`; false after `most_s` seconds. Polls, because counters have no
/// notification.
bool wait_until(const std::function<bool()>& holds, double most_s = 30);

}  // namespace fanlight::test
