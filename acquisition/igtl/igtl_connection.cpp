// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/igtl_connection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "proto/base/clock.hpp"
#include "proto/igtl/pose_bodies.hpp"
#include "proto/igtl/text_bodies.hpp"

namespace fanlight {

namespace {

constexpr int kStepMs = 20;
constexpr std::int64_t kFirstPauseNs = 100'000'000;
constexpr std::int64_t kMostPauseNs = 2'000'000'000;
constexpr std::int64_t kAliveNs = 2'000'000'000;
// The largest image of 16 bit, and room for metadata.
constexpr std::uint64_t kMostBodyBytes = std::uint64_t{4096} * 4096 * 2 + (1U << 20);
// Volumes and videos of other devices may be longer.
constexpr std::uint64_t kMostSkippedBytes = std::uint64_t{1} << 30;
// The name of a Fanlight's frames.
constexpr const char* kFrames = "Image_Transducer";
constexpr const char* kOurName = "Fanlight";

}  // namespace

IgtlConnection::IgtlConnection(const IgtlAddress& address, double silence_s, ProbeLink& link)
    : address_(address),
      silence_ns_(static_cast<std::int64_t>(silence_s * 1e9)),
      link_(link),
      counters_(link.igtl),
      socket_(address.host, address.port),
      reader_(kMostBodyBytes, kMostSkippedBytes) {
  status_.identity.model = "OpenIGTLink";
  status_.identity.serial = address.text();
}

IgtlConnection::Event IgtlConnection::step() {
  if (socket_.is_open()) return receive();
  connect();
  return Event::kNothing;
}

void IgtlConnection::connect() {
  if (now_ns() < next_try_ns_) {
    std::this_thread::sleep_for(std::chrono::milliseconds(kStepMs));
    return;
  }
  if (socket_.connect_step(kStepMs)) return connected();
  if (socket_.trouble().empty()) return;
  counters_.connections_failed.add();
  pause_ns_ = std::clamp(pause_ns_ * 2, kFirstPauseNs, kMostPauseNs);
  next_try_ns_ = now_ns() + pause_ns_;
  publish(number_ > 0 ? ProbeStatus::State::kLost : ProbeStatus::State::kAbsent,
          fmt::format("{} cannot be reached: {}", address_.text(), socket_.trouble()));
}

void IgtlConnection::connected() {
  counters_.connections_made.add();
  ++number_;
  reader_.restart();
  heard_ns_ = now_ns();
  said_alive_ns_ = heard_ns_;
  knows_version_2_ = false;
  publish(ProbeStatus::State::kAbsent, "");
  ask_for_images(igtl::HeadVersion::kOne);
  ask_for_poses();
}

/// Programs that send all they have to everybody ignore this.
void IgtlConnection::ask_for_images(igtl::HeadVersion version) {
  const std::string& image = address_.image;
  writer_.begin({.type = "STT_IMAGE",
                 .device = image.empty() ? igtl::DeviceName(kFrames) : igtl::DeviceName(image),
                 .version = version});
  socket_.send(writer_.finish());
}

/// Only version 2 has metadata. A program that does not know it would lose its place in what we send, so it
/// has to show first that it does.
void IgtlConnection::ask_in_version_2() {
  const igtl::MessageHead& head = reader_.head();
  const bool is_fanlight = head.type.view() == "STATUS" && head.device.view() == kOurName;
  if (knows_version_2_ || !(is_fanlight || head.version >= 2)) return;
  knows_version_2_ = true;
  ask_for_images(igtl::HeadVersion::kTwo);
}

void IgtlConnection::ask_for_poses() {
  igtl::put_start_of_tools(
      writer_.begin({.type = "STT_TDATA", .device = igtl::DeviceName(address_.transform)}), 0);
  socket_.send(writer_.finish());
}

void IgtlConnection::say_alive() {
  if (now_ns() - said_alive_ns_ < kAliveNs) return;
  said_alive_ns_ = now_ns();
  igtl::put_status(writer_.begin({.type = "STATUS", .device = kOurName}), {.name = "", .text = "reads"});
  socket_.send(writer_.finish());
}

void IgtlConnection::send_capability() {
  constexpr auto kTypes =
      std::to_array<std::string_view>({"IMAGE", "TRANSFORM", "TDATA", "STATUS", "CAPABILITY"});
  std::vector<igtl::TypeName> types(kTypes.begin(), kTypes.end());
  igtl::put_capability(writer_.begin({.type = "CAPABILITY", .device = kOurName}), types);
  socket_.send(writer_.finish());
}

IgtlConnection::Event IgtlConnection::receive() {
  using Read = igtl::MessageReader::Event;
  say_alive();
  const std::size_t bytes = socket_.receive(reader_.room(), kStepMs);
  if (!socket_.is_open()) {
    lose(socket_.trouble());
    return Event::kNothing;
  }
  if (bytes == 0) {
    if (now_ns() - heard_ns_ < silence_ns_) return Event::kNothing;
    counters_.silences.add();
    lose(fmt::format("no data for {:.0f} s", static_cast<double>(silence_ns_) * 1e-9));
    return Event::kNothing;
  }
  heard_ns_ = now_ns();
  counters_.bytes_received.add(bytes);
  switch (reader_.filled(bytes)) {
    case Read::kMore:
      break;
    case Read::kMessage:
      counters_.messages_received.add();
      pause_ns_ = 0;
      ask_in_version_2();
      return Event::kMessage;
    case Read::kSkipped:
      counters_.messages_received.add();
      counters_.messages_too_long.add();
      break;
    case Read::kLost:
    case Read::kUnwanted:
      counters_.places_lost.add();
      lose("its bytes are no OpenIGTLink message, expected a head of version 1 to 3 and a length up to 1 GB");
      break;
  }
  return Event::kNothing;
}

void IgtlConnection::lose(const std::string& why) {
  socket_.close();
  counters_.connections_lost.add();
  ++status_.times_lost;
  pause_ns_ = std::clamp(pause_ns_ * 2, kFirstPauseNs, kMostPauseNs);
  next_try_ns_ = now_ns() + pause_ns_;
  publish(ProbeStatus::State::kLost, fmt::format("the connection to {} is lost: {}", address_.text(), why));
}

void IgtlConnection::publish(ProbeStatus::State state, const std::string& trouble,
                             std::optional<FrameOrigin> origin) {
  if (status_.state == state && status_.trouble == trouble && status_.origin == origin) return;
  status_.state = state;
  status_.origin = origin;
  status_.trouble = trouble;
  link_.status.draft() = status_;
  link_.status.publish();
}

}  // namespace fanlight
