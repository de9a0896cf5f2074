#include "acquisition/usb_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "acquisition/probe_fit.hpp"
#include "proto/clock.hpp"

namespace fanlight {

namespace {

using Event = FrameParser::Event;

constexpr std::int64_t kNsInMs = 1'000'000;
constexpr double kNsInS = 1e9;

// Between looks at what else is to be done: a stop, an order, a silence. A transfer that ends wakes at once.
constexpr std::int64_t kEventsUs = 20'000;
// Where no udev runs, only a new look at all buses finds what was plugged in.
constexpr std::int64_t kLookNs = 250 * kNsInMs;
// The protocol asks for a frame a second at least.
constexpr std::int64_t kSilenceNs = 1'500 * kNsInMs;
// Between two steps of a source that is listened to; far above what a busy machine makes of it.
constexpr std::int64_t kPauseNs = 200 * kNsInMs;
// A probe that has counted this far has lost its mind; it must not make our own count wrap.
constexpr std::uint64_t kMostSequence = std::uint64_t{1} << 48;
// A probe whose geometry is in doubt is not asked with every frame.
constexpr std::int64_t kQuestionNs = 50 * kNsInMs;
// A probe that is taken and lost without a frame is looked for after twice the time, up to 4 s, and reset now
// and then.
constexpr std::uint32_t kMostDoublings = 4;
constexpr std::uint32_t kResetAfter = 3;
// After so many repairs without a whole frame the probe is let go, reset, and taken anew.
constexpr std::uint32_t kMostRepairs = 3;

/// The number of the last of a stream's frames or sweeps is kept, so that the next stream goes on after it.
void keep_last(std::uint64_t& next, std::uint64_t number) {
  next = std::max(next, number + 1);
}

Counter& counter_of(libusb_transfer_status trouble, ProbeCounters& counters) {
  switch (trouble) {
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
    : config_(config), link_(link), reads_(config.reads) {}

Result<std::unique_ptr<UsbSource>> UsbSource::create(const Config& config, ProbeLink& link) {
  if (!(config.wait_s >= 0)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the time to wait for the probe is {} s, expected 0 or more", config.wait_s)};
  }
  std::unique_ptr<UsbSource> made(new UsbSource(config, link));
  const std::int64_t give_up_ns = now_ns() + static_cast<std::int64_t>(std::min(config.wait_s, 1e9) * kNsInS);
  // Why a device that is there is not read says more than that the last look found none.
  Error reason{
      ErrorCode::kNotFound,
      fmt::format("no device {} is plugged in, expected a probe with that vendor, product and serial number "
                  "(lsusb lists what is there)",
                  config.address.text())};
  for (;;) {
    const auto looked = made->look_for_probe();
    if (made->probe_ != nullptr) break;
    if (!looked) reason = looked.error();
    if (now_ns() >= give_up_ns) return reason;
  }
  const Settings& asked = config.settings;
  if (asked.sweep_deg || asked.frames_a_volume || asked.depth_mm) {
    const probe::Settings& now = made->status_.settings;
    const probe::Settings wanted{.sweep_deg = asked.sweep_deg.value_or(now.sweep_deg),
                                 .frames_a_volume = asked.frames_a_volume.value_or(now.frames_a_volume),
                                 .depth_mm = asked.depth_mm.value_or(now.depth_mm)};
    if (auto applied = made->apply(wanted); !applied) return applied.error();
    if (auto described = made->describe(); !described) return described.error();
  }
  return made;
}

UsbSource::~UsbSource() {
  if (probe_ == nullptr) return;
  end_reads();
  reads_.release();
  (void)probe_->stop();  // it may be gone
}

// ---- plugged in and out

Result<void> UsbSource::look_for_probe() {
  if (bus_ == nullptr || now_ns() >= next_look_ns_) {
    next_look_ns_ = now_ns() + kLookNs;
    bus_ = nullptr;
    auto bus = UsbBus::create(config_.address);
    if (!bus) {
      std::this_thread::sleep_for(std::chrono::microseconds(kEventsUs));
      return bus.error();
    }
    bus_ = *std::move(bus);
  }
  Result<void> outcome;
  while (libusb_device* const device = bus_->next_arrival()) {
    outcome = take(device);
    libusb_unref_device(device);
    if (outcome) return outcome;
    say(outcome.error().message);
  }
  bus_->handle_events(kEventsUs);
  return outcome;
}

Result<void> UsbSource::take(libusb_device* device) {
  auto opened = UsbProbe::open(device, config_.address, link_.counters);
  if (!opened) return opened.error();
  probe_ = *std::move(opened);
  auto described = describe();
  if (described && wanted_) {
    // What a probe that comes back does not take is left as it has it.
    (void)apply(*wanted_);
    described = describe();
  }
  if (!described) {
    probe_ = nullptr;
    return described;
  }
  link_.counters.probes_found.add();
  stream_ = 0;
  repairs_in_a_row_ = 0;
  return {};
}

Result<void> UsbSource::describe() {
  auto identity = probe_->identity();
  if (!identity) return identity.error();
  auto capabilities = probe_->capabilities();
  if (!capabilities) return capabilities.error();
  const auto settings = probe_->settings();
  if (!settings) return settings.error();
  const auto geometry = probe_->geometry();
  if (!geometry) return geometry.error();
  if (auto checked = check_settings(*settings, *capabilities); !checked) {
    return Error{ErrorCode::kBadInput,
                 fmt::format("the probe is set to what it does not offer: {}", checked.error().message)};
  }
  if (description_.name.empty()) {
    description_.name = config_.address.text();
    description_.counts_volumes = capabilities->counts_volumes;
    description_.largest_frame_bytes = std::uint64_t{capabilities->most_columns} * capabilities->most_rows;
    description_.frames_per_volume = volume_capacity(*capabilities);
  } else if (geometry->fan != description_.geometry) {
    ++geometry_revision_;
  }
  // What was made at first does not grow: the ring's memory, and how sweeps are told apart.
  capabilities->most_frames = std::min(capabilities->most_frames, description_.frames_per_volume);
  if (auto fits = check_fit(*capabilities, *settings, geometry->fan, description_); !fits) return fits;
  geometry_ = *geometry;
  description_.geometry = geometry->fan;
  status_.identity = *std::move(identity);
  status_.capabilities = *capabilities;
  use_settings(*settings);
  return {};
}

void UsbSource::use_settings(const probe::Settings& settings) {
  status_.settings = settings;
  description_.usual_frames = settings.frames_a_volume;
  description_.last_angle_rad = radians(settings.sweep_deg / 2);
  description_.first_angle_rad = -description_.last_angle_rad;
}

void UsbSource::wait_for_probe() {
  (void)look_for_probe();  // why not is said in create(); here it is tried again and again
}

void UsbSource::lose() {
  end_reads();
  reads_.release();
  // One that came and went without a frame may be helped by a reset, and is not worth a look four times a
  // second.
  fruitless_ = status_.state == ProbeStatus::State::kStreaming ? 0 : fruitless_ + 1;
  if (fruitless_ > 0 && fruitless_ % kResetAfter == 0) (void)probe_->reset();
  probe_ = nullptr;
  next_look_ns_ = now_ns() + (kLookNs << std::min(fruitless_, kMostDoublings));
  link_.counters.probes_lost.add();
  if (status_.state != ProbeStatus::State::kStreaming) return;
  ++status_.times_lost;
  publish(ProbeStatus::State::kLost);
}

bool UsbSource::start_stream() {
  parser_.reset();
  clock_.reset();
  interrupted_ = true;
  first_sequence_ = next_sequence_;
  first_volume_ = next_volume_;
  ++stream_;
  last_bytes_ns_ = last_frame_ns_ = now_ns();
  // Stopped first: a program that ended without a word may have left it streaming.
  // A probe that refuses to stop is none that streams.
  const auto stopped = probe_->stop();
  if (!stopped && stopped.error().code != ErrorCode::kInvalidArgument) return false;
  if (!probe_->start()) return false;
  streaming_ = start_reads();
  return streaming_;
}

bool UsbSource::start_reads() {
  const std::uint32_t taken = reads_.start(probe_->handle(), probe_->endpoint());
  // None at all is most likely a probe that has just gone, and told as a loss.
  if (taken > 0) link_.counters.transfers_refused.add(config_.reads.transfers - taken);
  return taken > 0;
}

void UsbSource::end_reads() {
  streaming_ = false;
  reading_ = false;
  unread_ = {};
  trouble_.reset();
  parser_.reset();
  reads_.cancel();
  while (!reads_.empty()) {
    while (reads_.front() == nullptr) bus_->handle_events(kEventsUs);
    reads_.pop();
  }
}

// ---- while it streams

Result<std::optional<FrameStamp>> UsbSource::next_frame(std::stop_token stop) {
  while (!stop.stop_requested()) {
    follow_orders();
    if (probe_ == nullptr) {
      wait_for_probe();
    } else if (!streaming_) {
      if (!start_stream()) lose();
    } else if (step() == Event::kFrame) {
      announce();
      return std::optional(announced_);
    }
  }
  return std::optional<FrameStamp>{};
}

FrameFault UsbSource::read_pixels(std::span<std::uint8_t> pixels, std::stop_token stop) {
  parser_.take_pixels(pixels);
  const std::uint64_t stream = stream_;
  while (!stop.stop_requested() && streaming_ && stream == stream_) {
    const auto event = step();
    if (event == Event::kWhole) return FrameFault::kNone;
    if (event == Event::kDamaged) return FrameFault::kDamaged;
    if (event == Event::kCut) return FrameFault::kCut;
  }
  parser_.take_pixels({});
  return FrameFault::kCut;
}

std::optional<Event> UsbSource::step() {
  // Whoever took the last frame may have waited for room: the probe was not silent, we did not listen.
  const std::int64_t step_ns = now_ns();
  if (step_ns - std::exchange(last_step_ns_, step_ns) > kPauseNs) last_bytes_ns_ = last_frame_ns_ = step_ns;
  if (!reading_) {
    const TransferQueue::Read* read = reads_.front();
    if (read == nullptr) {
      if (reads_.empty()) {
        recover();
        return std::nullopt;
      }
      bus_->handle_events(kEventsUs);
      if (reads_.front() == nullptr) watch_silence();
      return std::nullopt;
    }
    begin_read(*read);
  }
  const Event event = parser_.next(unread_);
  if (event == Event::kMore) end_read();
  if (event == Event::kWhole) repairs_in_a_row_ = 0;
  return event;
}

void UsbSource::begin_read(const TransferQueue::Read& read) {
  ProbeCounters& counters = link_.counters;
  reading_ = true;
  unread_ = read.bytes;
  parser_.begin_transfer();
  counters.bytes_received.add(read.bytes.size());
  if (!read.bytes.empty()) last_bytes_ns_ = now_ns();
  if (read.status == LIBUSB_TRANSFER_COMPLETED) {
    counters.transfers_completed.add();
  } else if (!trouble_) {
    // All reads end, so that the bus is quiet while the pipe is repaired; those that are whole still count.
    trouble_ = read.status;
    reads_.cancel();
  }
}

void UsbSource::end_read() {
  ProbeCounters& counters = link_.counters;
  const TransferQueue::Read* const read = reads_.front();
  const bool is_short = read->bytes.size() < config_.reads.transfer_bytes;
  if (read->status == LIBUSB_TRANSFER_COMPLETED && is_short && parser_.in_frame())
    counters.transfers_short.add();
  const std::uint64_t skipped = parser_.bytes_skipped();
  counters.bytes_skipped.add(skipped - std::exchange(skipped_counted_, skipped));
  reading_ = false;
  counters.transfers_refused.add(reads_.pop());
  if (now_ns() - last_frame_ns_ > kSilenceNs && !trouble_)
    restart_stream();  // bytes, but no frame among them
}

void UsbSource::recover() {
  // Without a trouble: reads that the system refused, one after the other, until none was left.
  const libusb_transfer_status trouble = std::exchange(trouble_, {}).value_or(LIBUSB_TRANSFER_ERROR);
  const auto cleared = trouble == LIBUSB_TRANSFER_NO_DEVICE
                           ? Result<void>(Error{ErrorCode::kNotFound, "the probe is gone"})
                           : probe_->clear_halt();
  // A probe in the act of leaving often answers with an error first: that is a loss, and no failed transfer.
  if (!cleared && cleared.error().code == ErrorCode::kNotFound) {
    lose();
    return;
  }
  counter_of(trouble, link_.counters).add();
  if (!cleared || !start_reads()) {
    lose();
    return;
  }
  last_bytes_ns_ = now_ns();
  give_up_when_hopeless();
}

void UsbSource::watch_silence() {
  if (trouble_ || now_ns() - last_bytes_ns_ < kSilenceNs) return;
  link_.counters.transfers_timed_out.add();
  restart_stream();
}

void UsbSource::restart_stream() {
  link_.counters.streams_restarted.add();
  end_reads();
  (void)probe_->clear_halt();
  if (!start_stream()) {
    lose();
    return;
  }
  give_up_when_hopeless();
}

void UsbSource::give_up_when_hopeless() {
  if (++repairs_in_a_row_ <= kMostRepairs) return;
  end_reads();
  (void)probe_->reset();
  lose();
}

void UsbSource::announce() {
  const probe::FrameHeader& header = parser_.header();
  last_frame_ns_ = now_ns();
  if (status_.state != ProbeStatus::State::kStreaming) {
    status_.trouble.clear();
    publish(ProbeStatus::State::kStreaming);
  }
  fault_ = FrameFault::kNone;
  if (header.invalid) fault_ = FrameFault::kInvalid;
  if (header.format != probe::PixelFormat::kGrey8 || !knows_geometry_of(header) ||
      header.payload_bytes != description_.geometry.frame_bytes()) {
    fault_ = FrameFault::kMisfit;
  }
  announced_ = {.sequence = first_sequence_ + std::min(header.sequence, kMostSequence),
                .volume_index = first_volume_ + header.volume_index,
                .frame_index = header.frame_index,
                .frames_in_sweep = header.frames_in_sweep,
                .direction = header.direction,
                .angle_rad = radians(header.angle_deg),
                .geometry_revision = geometry_revision_,
                .after_interruption = std::exchange(interrupted_, false),
                .capture_time_ns = clock_.host_time_ns(header.device_time_ns, last_frame_ns_)};
  keep_last(next_sequence_, announced_.sequence);
  keep_last(next_volume_, announced_.volume_index);
}

bool UsbSource::knows_geometry_of(const probe::FrameHeader& header) {
  if (header.geometry_revision == geometry_.revision) return true;
  if (now_ns() - last_question_ns_ < kQuestionNs) return false;
  const auto geometry = probe_->geometry();
  last_question_ns_ = now_ns();
  if (!geometry) return false;
  geometry_ = *geometry;
  if (geometry_.fan != description_.geometry) {
    ++geometry_revision_;
    description_.geometry = geometry_.fan;
    publish(status_.state);
  }
  return header.geometry_revision == geometry_.revision;
}

// ---- settings

void UsbSource::follow_orders() {
  const ProbeOrder* const order = link_.orders.newest();
  if (order == nullptr) return;
  Result<void> applied;
  if (probe_ == nullptr) {
    applied = Error{ErrorCode::kUnavailable, "the probe is not plugged in, expected one to set"};
  } else {
    applied = apply(order->settings);
  }
  status_.order_answered = order->number;
  status_.refusal = applied ? std::string() : applied.error().message;
  publish(status_.state);
}

Result<void> UsbSource::apply(const probe::Settings& wanted) {
  const probe::Capabilities& offered = status_.capabilities;
  const probe::Settings& now = status_.settings;
  auto outcome = check_settings(wanted, offered);
  using probe::Request;
  if (outcome && wanted.sweep_deg != now.sweep_deg) {
    outcome =
        probe_->set(Request::kSetSweep, static_cast<std::uint32_t>(std::lround(wanted.sweep_deg * 1e6)));
  }
  if (outcome && wanted.frames_a_volume != now.frames_a_volume) {
    outcome = probe_->set(Request::kSetFrames, wanted.frames_a_volume);
  }
  if (outcome && wanted.depth_mm != now.depth_mm) {
    outcome = probe_->set(Request::kSetDepth, static_cast<std::uint32_t>(std::lround(wanted.depth_mm * 1e3)));
  }
  const auto in_force = probe_->settings();
  if (in_force) use_settings(*in_force);
  if (outcome && !in_force) outcome = in_force.error();
  // Also where a part of it was refused: what was taken before that stays.
  if (in_force) wanted_ = *in_force;
  (outcome ? link_.counters.settings_taken : link_.counters.settings_refused).add();
  return outcome;
}

void UsbSource::say(const std::string& trouble) {
  if (status_.trouble == trouble) return;
  status_.trouble = trouble;
  if (status_.state != ProbeStatus::State::kAbsent) publish(status_.state);
}

void UsbSource::publish(ProbeStatus::State state) {
  status_.state = state;
  status_.geometry = description_.geometry;
  link_.status.draft() = status_;
  link_.status.publish();
}

}  // namespace fanlight
