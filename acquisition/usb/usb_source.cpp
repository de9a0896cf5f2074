// SPDX-License-Identifier: Apache-2.0
#include "acquisition/usb/usb_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "proto/base/clock.hpp"
#include "proto/exchange/pulse.hpp"

namespace fanlight {

namespace {

using Event = FrameParser::Event;

constexpr double kNsInS = 1e9;
// Longest wait for an event of the bus: between two waits the source looks for a stop request, an order and a
// silence. A transfer that ends wakes it at once.
constexpr std::int64_t kEventsUs = 20'000;

Counter& counter_of(libusb_transfer_status failure, ProbeCounters& counters) {
  switch (failure) {
    case LIBUSB_TRANSFER_STALL:
      return counters.transfers_stalled;
    case LIBUSB_TRANSFER_OVERFLOW:
      return counters.transfers_overflowed;
    default:
      return counters.transfers_failed;
  }
}

}  // namespace

UsbSource::UsbSource(const Config& config, ProbeLink& link)
    : config_(config), link_(link), negotiation_(config.address, link), pipe_(config.reads, link.counters) {}

Result<std::unique_ptr<UsbSource>> UsbSource::create(const Config& config, ProbeLink& link) {
  if (!(config.wait_s >= 0)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the time to wait for the probe is {} s, expected 0 or more", config.wait_s)};
  }
  std::unique_ptr<UsbSource> made(new UsbSource(config, link));
  const std::int64_t give_up_ns = now_ns() + static_cast<std::int64_t>(std::min(config.wait_s, 1e9) * kNsInS);
  // Replaced by the last error about a device that is plugged in: it says more than that the last search
  // found none.
  Error reason{
      ErrorCode::kNotFound,
      fmt::format("no device {} is connected, expected a probe with that vendor, product and serial number "
                  "(see lsusb)",
                  config.address.text())};
  for (;;) {
    const auto found = made->search();
    if (made->probe_ != nullptr) break;
    if (!found) reason = found.error();
    if (now_ns() >= give_up_ns) return reason;
  }
  auto set = made->negotiation_.apply_start_settings(*made->probe_, config.settings);
  if (!set) return set.error();
  return made;
}

UsbSource::~UsbSource() {
  transition(SourceEvent::kStop);
}

// ---- transitions

/// Changes the state, and performs the work of entering it. States that are left at once (kRestarting,
/// kResetting) yield the next event. Behaviour: next_state().
void UsbSource::transition(SourceEvent event) {
  for (std::optional<SourceEvent> due = event; due;) {
    const SourceState next = next_state(state_, *due);
    // An unexpected event changes nothing, so nothing is entered again.
    if (next == state_) return;
    state_ = next;
    due = enter(state_);
  }
}

std::optional<SourceEvent> UsbSource::enter(SourceState state) {
  switch (state) {
    case SourceState::kWaiting:
      close_lost_probe();
      return std::nullopt;
    case SourceState::kStarting:
    case SourceState::kStreaming:
      return std::nullopt;
    case SourceState::kRepairing:
      // The bus must be quiet while the pipe is repaired. Frames of reads that ended before still count.
      pipe_.cancel();
      return std::nullopt;
    case SourceState::kRestarting:
      return restart();
    case SourceState::kResetting:
      pipe_.end(*bus_);
      (void)probe_->reset();
      return SourceEvent::kProbeLost;
    case SourceState::kStopped:
      stop();
      return std::nullopt;
  }
  return std::nullopt;
}

// ---- waiting for a probe

/// Searches once, for up to kEventsUs. An error names a device that is plugged in and cannot be used.
Result<void> UsbSource::search() {
  if (bus_ == nullptr || now_ns() >= search_.next_bus_ns) {
    search_.next_bus_ns = now_ns() + ReturnBackoff::kSearchNs;
    bus_ = nullptr;
    auto bus = UsbBus::create(config_.address);
    if (!bus) {
      std::this_thread::sleep_for(std::chrono::microseconds(kEventsUs));
      Pulse::beat();
      return bus.error();
    }
    bus_ = *std::move(bus);
  }
  Result<void> outcome;
  while (libusb_device* const device = bus_->next_arrival()) {
    outcome = open(device);
    libusb_unref_device(device);
    if (outcome) return outcome;
    negotiation_.report_trouble(outcome.error().message);
  }
  bus_->handle_events(kEventsUs);
  return outcome;
}

Result<void> UsbSource::open(libusb_device* device) {
  auto opened = UsbProbe::open(device, config_.address, link_.counters);
  if (!opened) return opened.error();
  if (auto negotiated = negotiation_.negotiate(**opened); !negotiated) return negotiated;
  probe_ = *std::move(opened);
  link_.counters.probes_found.add();
  repair_.limit.probe_opened();
  transition(SourceEvent::kProbeOpened);
  return {};
}

void UsbSource::close_lost_probe() {
  pipe_.end(*bus_);
  pipe_.release();
  const ReturnBackoff::Decision decision = search_.backoff.probe_lost(negotiation_.had_frames());
  if (decision.reset_probe) (void)probe_->reset();
  probe_ = nullptr;
  search_.next_bus_ns = now_ns() + decision.search_delay_ns;
  link_.counters.probes_lost.add();
  negotiation_.report_loss();
}

void UsbSource::stop() {
  if (probe_ == nullptr) return;
  pipe_.end(*bus_);
  pipe_.release();
  (void)probe_->stop();  // it may be gone
}

// ---- streaming

bool UsbSource::start_stream() {
  pipe_.reset_parser();
  numbering_.stream_started();
  stream_.clock.reset();
  stream_.silence.stream_started(now_ns());
  stream_.first_frame_due = true;
  ++stream_.number;
  // Stopped first: a program that was killed may have left the probe streaming. A probe that refuses to stop
  // does not stream.
  const auto stopped = probe_->stop();
  if (!stopped && stopped.error().code != ErrorCode::kInvalidArgument) return false;
  return probe_->start() && pipe_.start(*probe_);
}

Result<std::optional<FrameStamp>> UsbSource::next_frame(std::stop_token stop) {
  thread_owner_.check();
  while (!stop.stop_requested()) {
    negotiation_.answer_order(probe_.get());
    if (state_ == SourceState::kWaiting) {
      (void)search();  // create() returned its error; from now on it is tried again and again
    } else if (state_ == SourceState::kStarting) {
      transition(start_stream() ? SourceEvent::kStarted : SourceEvent::kProbeLost);
    } else if (step() == Event::kFrame) {
      announce();
      return std::optional(announced_.stamp);
    }
  }
  return std::optional<FrameStamp>{};
}

FrameFault UsbSource::read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) {
  thread_owner_.check();
  pipe_.take_pixels(pixels);
  const std::uint64_t stream_number = stream_.number;
  while (!stop.stop_requested() && in_stream() && stream_.number == stream_number) {
    const auto event = step();
    if (event == Event::kWhole) return FrameFault::kNone;
    if (event == Event::kDamaged) return FrameFault::kDamaged;
    if (event == Event::kCut) return FrameFault::kCut;
  }
  pipe_.take_pixels({});
  return FrameFault::kCut;
}

/// One step of the stream: waits up to kEventsUs for a read, or parses up to the next event. Precondition:
/// in_stream(). nullopt: no bytes were parsed; the state may have changed.
std::optional<Event> UsbSource::step() {
  stream_.silence.polled(now_ns());
  if (!pipe_.reading() && !open_read()) return std::nullopt;
  const Event event = pipe_.parse();
  if (event == Event::kWhole) repair_.limit.frame_completed();
  if (event == Event::kMore && state_ == SourceState::kStreaming &&
      stream_.silence.without_frames(now_ns())) {
    transition(SourceEvent::kSilent);
  }
  return event;
}

bool UsbSource::open_read() {
  if (pipe_.empty()) {
    if (state_ == SourceState::kStreaming) {  // the system refused one read after the other
      repair_.failure = LIBUSB_TRANSFER_ERROR;
      transition(SourceEvent::kReadFailed);
    }
    transition(repair());
    return false;
  }
  if (!pipe_.has_ended_read()) {
    bus_->handle_events(kEventsUs);
    if (!pipe_.has_ended_read() && state_ == SourceState::kStreaming &&
        stream_.silence.without_bytes(now_ns())) {
      link_.counters.transfers_timed_out.add();
      transition(SourceEvent::kSilent);
    }
    return false;
  }
  const FramePipe::OpenedRead read = pipe_.open_read();
  if (read.has_bytes) stream_.silence.bytes_received(now_ns());
  if (read.status != LIBUSB_TRANSFER_COMPLETED && state_ == SourceState::kStreaming) {
    repair_.failure = read.status;
    transition(SourceEvent::kReadFailed);
  }
  return true;
}

// ---- repairing and restarting

/// All reads have ended after a failure: clears the halt and starts reading again.
SourceEvent UsbSource::repair() {
  const auto cleared = repair_.failure == LIBUSB_TRANSFER_NO_DEVICE
                           ? Result<void>(Error{ErrorCode::kNotFound, "the probe was disconnected"})
                           : probe_->clear_halt();
  // A probe that is being unplugged often answers with an error first: that is a loss and no failed transfer.
  if (!cleared && cleared.error().code == ErrorCode::kNotFound) return SourceEvent::kProbeLost;
  counter_of(repair_.failure, link_.counters).add();
  if (!cleared || !pipe_.start(*probe_)) return SourceEvent::kProbeLost;
  stream_.silence.bytes_received(now_ns());
  return repair_.limit.allows_repair() ? SourceEvent::kRepaired : SourceEvent::kRepairedTooOften;
}

SourceEvent UsbSource::restart() {
  link_.counters.streams_restarted.add();
  pipe_.end(*bus_);
  (void)probe_->clear_halt();
  if (!start_stream()) return SourceEvent::kProbeLost;
  return repair_.limit.allows_repair() ? SourceEvent::kStarted : SourceEvent::kRepairedTooOften;
}

// ---- frames

void UsbSource::announce() {
  const probe::FrameHeader& header = pipe_.header();
  const std::int64_t arrival_ns = now_ns();
  stream_.silence.frame_received(arrival_ns);
  negotiation_.report_frame();
  announced_.fault = fault_of(header);
  announced_.stamp = {
      .sequence = numbering_.sequence(header.sequence),
      .volume_index = numbering_.volume_index(header.volume_index),
      .frame_index = header.frame_index,
      .frames_in_sweep = header.frames_in_sweep,
      .direction = header.direction,
      .angle_rad = radians(header.angle_deg),
      .geometry_revision = negotiation_.geometry_revision(),
      .after_interruption = std::exchange(stream_.first_frame_due, false),
      .capture_time_ns = stream_.clock.host_time_ns(header.device_time_ns, arrival_ns),
  };
}

FrameFault UsbSource::fault_of(const probe::FrameHeader& header) {
  if (header.format != probe::PixelFormat::kGrey8 || !negotiation_.knows_geometry_of(header, *probe_) ||
      header.payload_bytes != description().geometry.frame_bytes()) {
    return FrameFault::kMisfit;
  }
  return header.invalid ? FrameFault::kInvalid : FrameFault::kNone;
}

}  // namespace fanlight
