// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "acquisition/source/device_clock.hpp"
#include "acquisition/source/frame_source.hpp"
#include "acquisition/usb/frame_pipe.hpp"
#include "acquisition/usb/probe_negotiation.hpp"
#include "acquisition/usb/recovery_policy.hpp"
#include "acquisition/usb/source_state.hpp"
#include "acquisition/usb/stream_numbering.hpp"
#include "acquisition/usb/usb_bus.hpp"
#include "acquisition/usb/usb_probe.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/exchange/probe_link.hpp"

namespace fanlight {

/// A 4D probe on USB (proto/usb_probe.md). The stream never ends by itself: after a loss the source waits for
/// the probe, opens it again, and applies its last settings. Faults of cable and probe are counted in
/// ProbeCounters; acquisition/FAULTS.md lists them.
///
/// A state machine (SourceState): step() performs the work of the present state, transition() is the only
/// function that changes it. All of it runs on the thread that calls next_frame().
class UsbSource final : public FrameSource {
 public:
  using Settings = ProbeStartSettings;
  struct Config {
    UsbAddress address;
    Settings settings;
    double wait_s = 5;  ///< how long create() waits for a probe that is not plugged in; at least 0
    TransferQueue::Config reads;
  };

  /// Finds the probe, waits for it if needed, and asks for its description; the stream is not started.
  /// kNotFound: no such probe within wait_s. kUnavailable or kBadInput: it cannot be used. kInvalidArgument:
  /// it does not take a setting. `link` must outlive the source.
  static Result<std::unique_ptr<UsbSource>> create(const Config& config, ProbeLink& link);
  ~UsbSource() override;

  const SourceDescription& description() const override { return negotiation_.description(); }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override;
  FrameFault known_fault() const override { return announced_.fault; }
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) override;

 private:
  UsbSource(const Config& config, ProbeLink& link);

  // State kWaiting: the search for a probe.
  struct Search {
    std::int64_t next_bus_ns = 0;  // when the buses are enumerated again
    ReturnBackoff backoff;
  };
  // States kStreaming and kRepairing: the stream that was started last.
  struct Stream {
    std::uint64_t number = 0;  // counts starts
    SilenceWatch silence;
    DeviceClock clock;
    bool first_frame_due = false;  // no frame was announced since the start
  };
  // States kRepairing and kRestarting.
  struct Repair {
    libusb_transfer_status failure = LIBUSB_TRANSFER_ERROR;  // of the first read that failed
    RepairLimit limit;
  };
  // The frame of the last next_frame().
  struct Announced {
    FrameStamp stamp;
    FrameFault fault = FrameFault::kNone;
  };

  void transition(SourceEvent event);
  std::optional<SourceEvent> enter(SourceState state);

  Result<void> search();
  Result<void> open(libusb_device* device);
  void close_lost_probe();
  void stop();

  bool start_stream();
  bool in_stream() const { return state_ == SourceState::kStreaming || state_ == SourceState::kRepairing; }
  std::optional<FrameParser::Event> step();
  bool open_read();
  SourceEvent repair();
  SourceEvent restart();
  void announce();
  FrameFault fault_of(const probe::FrameHeader& header);

  Config config_;
  ProbeLink& link_;
  ProbeNegotiation negotiation_;

  SourceState state_ = SourceState::kWaiting;
  Search search_;
  Stream stream_;
  Repair repair_;
  StreamNumbering numbering_;
  Announced announced_;

  // Destroyed from the last to the first: a probe needs its bus, and no read may be pending by then.
  std::unique_ptr<UsbBus> bus_;
  std::unique_ptr<UsbProbe> probe_;  // nullptr in kWaiting
  FramePipe pipe_;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
