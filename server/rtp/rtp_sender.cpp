// SPDX-License-Identifier: Apache-2.0
#include "server/rtp/rtp_sender.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <utility>

#include "proto/base/clock.hpp"
#include "proto/fanlight.pb.h"
#include "server/rtp/h264_payloads.hpp"
#include "server/rtp/rtp_packet.hpp"
#include "server/rtp/sdp.hpp"
#include "server/rtp/user_data_sei.hpp"

namespace fanlight {

namespace asio = boost::asio;

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr auto kTick = std::chrono::milliseconds(250);
// A receiver without RTCP, such as a player with an SDP file, waits so long for its first picture.
constexpr std::int64_t kBetweenKeysNs = 2 * kSecondNs;
constexpr std::int64_t kBetweenReportsNs = kSecondNs;
// A receiver whose name may have another address by now: an SFU that was started elsewhere.
constexpr std::int64_t kSilentNs = 10 * kSecondNs;
// RTP, UDP, IP and SRTP of the sender and of an SFU's DTLS fit into the least MTU of IPv6 with it.
constexpr std::size_t kMostPayloadBytes = 1150;
constexpr int kSendBufferBytes = 1 << 20;  // a key picture at once

std::uint64_t random_number() {
  std::random_device device;
  return static_cast<std::uint64_t>(device()) << 32 | device();
}

/// What SEI messages say of a picture, as JSON: all that displays get, without the picture itself.
std::string picture_data(v1::Picture& picture, const PictureLiveness::Report& report,
                         const std::string& title) {
  v1::RelayedPicture data;
  const std::int64_t now = now_ns();
  const auto utc = static_cast<std::int64_t>(utc_now_ns());
  data.set_capture_utc_ns(utc - (now - picture.capture_time_ns()));
  data.set_sent_utc_ns(utc);
  data.set_title(title);
  data.set_state(PictureLiveness::name(report.state));
  data.set_sentence(report.sentence);
  data.mutable_picture()->Swap(&picture);
  data.mutable_picture()->clear_stages();
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  std::string text;
  (void)google::protobuf::util::MessageToJsonString(data, &text, options);
  return text;
}

}  // namespace

RtpSender::RtpSender(asio::io_context& loop, const Config& config, Dependencies dependencies)
    : config_(config),
      dependencies_(std::move(dependencies)),
      file_(config.sdp_file, dependencies_.executor),
      settings_{.codec = StreamSettings::Codec::kH264, .bit_rate_kbps = config.bit_rate_kbps},
      resolver_(loop),
      packets_(loop),
      control_(loop),
      pause_(loop) {}

RtpSender::~RtpSender() {
  dependencies_.changed = [] {};  // there is no one left to notify
  stop();
}

std::string RtpSender::to() const {
  const bool v6 = config_.host.find(':') != std::string::npos;
  return v6 ? fmt::format("[{}]:{}", config_.host, config_.port)
            : fmt::format("{}:{}", config_.host, config_.port);
}

RelayReport RtpSender::report() const {
  RelayReport report{.sending = sending_,
                     .to = to(),
                     .encrypted = encrypted(),
                     .description = description_,
                     .reception = {}};
  if (!has_report_ || now_ns() - reported_ns_ > kSilentNs) return report;
  report.reception = {.lost_percent = 100 * report_.lost_share,
                      .lost_packets = std::max(report_.lost, 0),
                      .jitter_ms = report_.jitter / (kRtpClockHz / 1000.0)};
  return report;
}

Result<void> RtpSender::start() {
  thread_owner_.check();
  if (sending_) return Error{ErrorCode::kUnavailable, fmt::format("pictures are sent to {} already", to())};
  srtp_.reset();
  if (encrypted()) {
    auto context = SrtpContext::create(config_.srtp_key);
    if (!context) return context.error();
    srtp_ = *std::move(context);
  }
  // By RFC 3550, sequence and timestamp begin at random.
  source_ = static_cast<std::uint32_t>(random_number());
  sequence_ = static_cast<std::uint16_t>(random_number() & 0x7fff);  // room below the wrap, for SRTP
  clock_ = RtpClock(static_cast<std::uint32_t>(random_number()), now_ns());
  session_ = utc_now_ns();
  packets_sent_ = payload_bytes_sent_ = 0;
  description_version_ = 0;
  last_picture_id_ = 0;
  key_sent_ns_ = heard_ns_ = 0;
  has_report_ = complained_ = false;
  sending_ = true;
  resolve();
  keep_alive();
  dependencies_.changed();
  return {};
}

void RtpSender::stop() {
  if (!std::exchange(sending_, false)) return;
  spdlog::info("stopped sending pictures to {}", to());
  // Who has sent nothing says no BYE (RFC 3550, section 6.3.7).
  if (control_.is_open() && (packets_sent_ > 0 || report_due_ns_ > 0)) report_ourselves(true);
  close();
  resolver_.cancel();
  pause_.cancel();
  description_.clear();
  file_.remove();
  dependencies_.changed();
}

void RtpSender::close() {
  dependencies_.hub.remove(*this);
  boost::system::error_code none;
  packets_.close(none);
  control_.close(none);
}

void RtpSender::keep_alive() {
  if (!sending_) return;
  if (tick_chain_.broken()) tick();
  if (control_.is_open() && receive_chain_.broken()) receive();
}

void RtpSender::resolve() {
  if (!resolve_chain_.broken()) return;
  resolved_ns_ = now_ns();
  resolver_.async_resolve(
      config_.host, std::to_string(config_.port),
      [this, link = resolve_chain_.link()](boost::system::error_code failure,
                                           const Udp::resolver::results_type& found) {
        if (!sending_) return;
        if (failure == asio::error::operation_aborted) {
          resolved_ns_ = 0;  // of a stream that was stopped and started meanwhile: the next tick tries again
        } else {
          resolved(failure, found);
        }
      });
}

void RtpSender::resolved(boost::system::error_code failure, const Udp::resolver::results_type& found) {
  Result<void> connected;
  if (failure || found.empty()) {
    if (control_.is_open()) return;  // it still goes to where it went
    connected = Error{ErrorCode::kNotFound, failure.message()};
  } else if (reaches_one_of(found)) {
    return;
  } else {
    connected = connect(found.begin()->endpoint());
  }
  if (connected || std::exchange(complained_, true)) return;
  spdlog::warn("pictures cannot be sent to {}: {}; tries again every 10 s", to(), connected.error().message);
}

bool RtpSender::reaches_one_of(const Udp::resolver::results_type& found) const {
  if (!control_.is_open()) return false;
  boost::system::error_code failure;
  const auto now = control_.remote_endpoint(failure).address();
  return !failure && std::ranges::any_of(found, [&now](const auto& entry) {
    return entry.endpoint().address() == now;  // a name with several addresses has them in any order
  });
}

Result<void> RtpSender::connect(const Udp::endpoint& receiver) {
  close();
  boost::system::error_code failure;
  for (auto* const socket : {&packets_, &control_}) {
    const auto port = static_cast<std::uint16_t>(receiver.port() + (socket == &control_ ? 1 : 0));
    if (!failure) socket->open(receiver.protocol(), failure);
    if (!failure) socket->non_blocking(true, failure);
    if (!failure) socket->connect({receiver.address(), port}, failure);
  }
  if (failure) {
    close();
    return Error{ErrorCode::kUnavailable, failure.message()};
  }
  boost::system::error_code none;  // a smaller buffer does too
  packets_.set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), none);
  complained_ = has_report_ = false;
  wants_key_ = true;
  report_due_ns_ = 0;
  description_.clear();  // it names the receiver
  ++connection_;
  spdlog::info("sending pictures as {} to {} ({})", encrypted() ? "SRTP" : "RTP", to(),
               receiver.address().to_string());
  try {
    dependencies_.hub.add(*this);
  } catch (...) {
    close();  // so that the next try adds it
    throw;
  }
  receive();
  return {};
}

void RtpSender::tick() {
  pause_.expires_after(kTick);
  pause_.async_wait([this, link = tick_chain_.link()](boost::system::error_code failure) {
    if (failure || !sending_) return;
    ticked();
    tick();
  });
}

void RtpSender::ticked() {
  const std::int64_t now = now_ns();
  if (now - std::max(heard_ns_, resolved_ns_) > kSilentNs) resolve();
  if (!control_.is_open()) return;
  if (now >= report_due_ns_) {
    report_ourselves(false);
    // At random around the interval, so that senders do not fall into step (RFC 3550, section 6.3.1).
    report_due_ns_ =
        now + kBetweenReportsNs / 2 + static_cast<std::int64_t>(random_number() % kBetweenReportsNs);
  }
  if (wants_key_ || now - key_sent_ns_ > kBetweenKeysNs) dependencies_.hub.resync(*this);
}

void RtpSender::receive() {
  control_.async_receive(
      asio::buffer(incoming_), [this, link = receive_chain_.link(), connection = connection_](
                                   boost::system::error_code failure, std::size_t bytes) {
        // What came from an earlier receiver must not begin a second chain.
        if (failure == asio::error::operation_aborted || !sending_ || connection != connection_) return;
        if (!control_.is_open()) return;
        // Without a listener, the system says so: connection_refused.
        if (!failure) received(bytes);
        receive();
      });
}

void RtpSender::received(std::size_t bytes) {
  std::vector<std::uint8_t> packet(incoming_.begin(), incoming_.begin() + static_cast<std::ptrdiff_t>(bytes));
  // Some SFUs send their feedback unprotected. It may ask for a key picture, of which the hub makes one a
  // second at most, and is believed in nothing else.
  const bool is_authentic = srtp_ == nullptr || srtp_->unprotect_rtcp(packet);
  const auto feedback = parse_rtcp(packet, source_);
  if (!feedback) return dependencies_.state.counters.rtp_feedback_refused.add();
  if (is_authentic && is_plausible(*feedback)) believe(*feedback);
  if (!feedback->key_wanted) return;
  dependencies_.state.counters.rtp_keys_requested.add();
  wants_key_ = true;
  dependencies_.hub.resync(*this);
}

/// Without SRTP any process on this machine may send a report; what cannot be true is counted as refused.
bool RtpSender::is_plausible(const RtcpFeedback& feedback) const {
  const bool plausible =
      !feedback.report || feedback.report->lost <= static_cast<std::int64_t>(packets_sent_);
  if (!plausible) dependencies_.state.counters.rtp_feedback_refused.add();
  return plausible;
}

void RtpSender::believe(const RtcpFeedback& feedback) {
  heard_ns_ = now_ns();
  dependencies_.state.counters.rtp_packets_not_resent.add(feedback.packets_wanted);
  if (!feedback.report) return;
  report_ = *feedback.report;
  reported_ns_ = heard_ns_;
  has_report_ = true;
  dependencies_.state.counters.rtp_reports_received.add();
}

void RtpSender::report_ourselves(bool ends) {
  std::vector<std::uint8_t> packet = rtcp_packet({.source = source_,
                                                  .ntp = ntp_time(utc_now_ns()),
                                                  .timestamp = clock_.at(now_ns()),
                                                  .packets = packets_sent_,
                                                  .bytes = payload_bytes_sent_},
                                                 fmt::format("fanlight-{:08x}", source_), ends);
  if (srtp_ != nullptr && !srtp_->protect_rtcp(packet))
    return dependencies_.state.counters.rtp_send_failures.add();
  (void)send(control_, packet);
}

bool RtpSender::send(Udp::socket& socket, const std::vector<std::uint8_t>& packet) {
  boost::system::error_code failure;
  socket.send(asio::buffer(packet), 0, failure);
  // The system reports an earlier packet without a listener; this one was not sent.
  if (failure == asio::error::connection_refused) socket.send(asio::buffer(packet), 0, failure);
  if (failure) dependencies_.state.counters.rtp_send_failures.add();
  return !failure;
}

void RtpSender::offer(const PictureOffer& offered) {
  thread_owner_.check();
  if (!packets_.is_open()) return;
  v1::ServerMessage message;
  if (!message.ParseFromString(*offered.message) || !message.has_picture()) return;
  v1::Picture& picture = *message.mutable_picture();
  const std::unique_ptr<std::string> stream(picture.release_h264());
  if (stream == nullptr) return;
  const std::int64_t now = now_ns();
  // A picture that is encoded once more, as a key picture, has a time of its own.
  const bool is_new = std::exchange(last_picture_id_, picture.picture_id()) != picture.picture_id();
  const std::uint32_t timestamp = clock_.next(is_new ? picture.finished_time_ns() : now);
  if (offered.key) {
    key_sent_ns_ = now;
    wants_key_ = false;
  }
  const std::vector<std::uint8_t> data = user_data_sei(
      picture_data(picture, dependencies_.state.liveness.report(), dependencies_.state.description.title));
  auto units = nal_units({reinterpret_cast<const std::uint8_t*>(stream->data()), stream->size()});
  // After the parameter sets, before the picture (H.264, 7.4.1.2.3).
  const auto picture_begins = std::ranges::find_if(units, [](const auto& unit) {
    return nal_kind(unit) == NalKind::kSlice || nal_kind(unit) == NalKind::kKeySlice;
  });
  units.insert(picture_begins, data);
  if (offered.key) describe(units);
  send_units(units, timestamp);
}

void RtpSender::send_units(std::span<const std::span<const std::uint8_t>> units, std::uint32_t timestamp) {
  const auto payloads = h264_payloads(units, kMostPayloadBytes);
  for (const auto& payload : payloads) {
    packet_.clear();
    put_rtp_header(packet_, {.payload_type = kRtpPayloadType,
                             .marker = &payload == &payloads.back(),
                             .sequence = sequence_++,
                             .timestamp = timestamp,
                             .source = source_});
    packet_.insert(packet_.end(), payload.begin(), payload.end());
    const bool is_protected = srtp_ == nullptr || srtp_->protect_rtp(packet_);
    if (!is_protected) dependencies_.state.counters.rtp_send_failures.add();
    if (!is_protected || !send(packets_, packet_)) {
      wants_key_ = true;  // the rest of this picture is of no use, nor what refers to it
      return dependencies_.state.counters.rtp_pictures_cut.add();
    }
    ++packets_sent_;
    payload_bytes_sent_ += static_cast<std::uint32_t>(payload.size());
    dependencies_.state.counters.rtp_packets_sent.add();
    dependencies_.state.counters.rtp_bytes_sent.add(packet_.size());
  }
  dependencies_.state.counters.rtp_pictures_sent.add();
}

void RtpSender::describe(std::span<const std::span<const std::uint8_t>> units) {
  bool changed = description_.empty();
  for (const auto& unit : units) {
    auto* const kept = nal_kind(unit) == NalKind::kSequenceSet  ? &sequence_set_
                       : nal_kind(unit) == NalKind::kPictureSet ? &picture_set_
                                                                : nullptr;
    if (kept == nullptr || std::ranges::equal(*kept, unit)) continue;
    kept->assign(unit.begin(), unit.end());
    changed = true;
  }
  if (!changed) return;
  boost::system::error_code failure;
  const auto here = packets_.local_endpoint(failure);
  const auto there = packets_.remote_endpoint(failure);
  if (failure) return;
  description_ = sdp({.title = dependencies_.state.description.title,
                      .from = here.address().to_string(),
                      .to = there.address().to_string(),
                      .v6 = there.address().is_v6(),
                      .port = there.port(),
                      .source = source_,
                      .session = session_,
                      .version = ++description_version_,
                      .name = fmt::format("fanlight-{:08x}", source_),
                      .sequence_set = sequence_set_,
                      .picture_set = picture_set_,
                      .srtp_key = config_.srtp_key});
  file_.write(description_);
}

void RtpSender::encoding_failed() {
  thread_owner_.check();
  // The hub counts it, and the next picture tries again; it must be a key picture then.
  wants_key_ = true;
}

}  // namespace fanlight
