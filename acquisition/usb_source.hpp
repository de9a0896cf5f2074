#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "acquisition/device_clock.hpp"
#include "acquisition/frame_parser.hpp"
#include "acquisition/frame_source.hpp"
#include "acquisition/transfer_queue.hpp"
#include "acquisition/usb_bus.hpp"
#include "acquisition/usb_probe.hpp"
#include "proto/probe_link.hpp"

namespace fanlight {

/// A 4D probe on USB (proto/usb_probe.md). Never ends by itself: a probe that is unplugged is waited for and
/// taken again, with the settings that it had; what cable and probe do meanwhile is counted in ProbeCounters,
/// and acquisition/README.md has the table.
class UsbSource final : public FrameSource {
 public:
  /// What is set before the first frame; absent: as the probe has it.
  struct Settings {
    std::optional<double> sweep_deg;
    std::optional<std::uint32_t> frames_a_volume;
    std::optional<double> depth_mm;
  };
  struct Config {
    UsbAddress address;
    Settings settings;
    double wait_s = 5;  ///< for a probe that is not there when the source is made; 0 and more
    TransferQueue::Config reads;
  };

  /// Finds the probe, waiting for it, and asks who it is; it does not stream yet. kNotFound where it did not
  /// come, kUnavailable or kBadInput where it cannot be used, kInvalidArgument where it does not take a
  /// setting. `link` must outlive the source.
  static Result<std::unique_ptr<UsbSource>> create(const Config& config, ProbeLink& link);
  ~UsbSource() override;

  const SourceDescription& description() const override { return description_; }
  Result<std::optional<FrameStamp>> next_frame(std::stop_token stop) override;
  FrameFault known_fault() const override { return fault_; }
  FrameFault read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) override;

 private:
  UsbSource(const Config& config, ProbeLink& link);

  // Plugged in and out.
  Result<void> look_for_probe();
  Result<void> take(libusb_device* device);
  Result<void> describe();
  void wait_for_probe();
  void lose();
  bool start_stream();
  bool start_reads();
  void end_reads();

  // While it streams.
  std::optional<FrameParser::Event> step();
  void begin_read(const TransferQueue::Read& read);
  void end_read();
  void recover();
  void restart_stream();
  void give_up_when_hopeless();
  void watch_silence();
  void announce();
  bool knows_geometry_of(const probe::FrameHeader& header);

  // Settings.
  void follow_orders();
  Result<void> apply(const probe::Settings& wanted);
  void use_settings(const probe::Settings& settings);
  void say(const std::string& trouble);
  void publish(ProbeStatus::State state);

  Config config_;
  ProbeLink& link_;
  SourceDescription description_;
  ProbeStatus status_;
  std::optional<probe::Settings> wanted_;  // what was asked for last; set again after a loss
  probe::Geometry geometry_;               // as the probe numbers it
  std::uint32_t geometry_revision_ = 0;    // as our stamps do: also over a loss it only grows

  // A probe must go before its bus, and have no read under way by then.
  std::unique_ptr<UsbBus> bus_;
  std::unique_ptr<UsbProbe> probe_;
  TransferQueue reads_;
  std::int64_t next_look_ns_ = 0;
  std::int64_t last_bytes_ns_ = 0;
  std::int64_t last_frame_ns_ = 0;
  std::int64_t last_question_ns_ = 0;  // for the geometry
  std::int64_t last_step_ns_ = 0;
  std::uint32_t fruitless_ = 0;         // times that a probe was taken and lost without a frame
  std::uint32_t repairs_in_a_row_ = 0;  // of the stream, without a whole frame in between
  std::uint64_t stream_ = 0;            // counts starts; 0: not yet started since the probe was taken
  bool streaming_ = false;

  FrameParser parser_;
  std::uint64_t skipped_counted_ = 0;
  std::span<const std::uint8_t> unread_;  // of the oldest read
  bool reading_ = false;                  // that read was not given back yet
  /// Why all reads are being ended, while they are.
  std::optional<libusb_transfer_status> trouble_;

  DeviceClock clock_;
  FrameStamp announced_;
  FrameFault fault_ = FrameFault::kNone;  // of the frame announced
  bool interrupted_ = false;              // before the frame to come
  // The probe counts from 0 with each start, we go on: the numbers of this stream's first frame and sweep.
  std::uint64_t first_sequence_ = 0;
  std::uint64_t next_sequence_ = 0;
  std::uint64_t first_volume_ = 0;
  std::uint64_t next_volume_ = 0;
};

}  // namespace fanlight
