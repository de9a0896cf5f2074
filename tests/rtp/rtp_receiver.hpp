// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

namespace fanlight::test {

/// The NAL units of RTP payloads, by RFC 6184: single units, STAP-A and FU-A. Throws on anything else.
inline std::vector<std::vector<std::uint8_t>> unpacked(
    const std::vector<std::vector<std::uint8_t>>& payloads) {
  std::vector<std::vector<std::uint8_t>> units;
  for (const auto& payload : payloads) {
    const int kind = payload.at(0) & 31;
    if (kind == 24) {
      for (std::size_t at = 1; at < payload.size();) {
        const std::size_t bytes = payload.at(at) * 256U + payload.at(at + 1);
        units.emplace_back(payload.begin() + static_cast<std::ptrdiff_t>(at + 2),
                           payload.begin() + static_cast<std::ptrdiff_t>(at + 2 + bytes));
        at += 2 + bytes;
      }
    } else if (kind == 28) {
      if ((payload.at(1) & 0x80) != 0)
        units.emplace_back(1, static_cast<std::uint8_t>((payload[0] & 0xe0) | (payload[1] & 31)));
      units.back().insert(units.back().end(), payload.begin() + 2, payload.end());
    } else if (kind >= 1 && kind <= 23) {
      units.push_back(payload);
    } else {
      throw std::runtime_error("a payload of another kind");
    }
  }
  return units;
}

/// The receiver's two sockets, on ports of this machine that follow each other.
class RtpReceiver {
 public:
  using Udp = boost::asio::ip::udp;

  RtpReceiver() {
    for (int i = 0; i < 200; ++i) {
      Udp::socket first(loop_, {boost::asio::ip::make_address("127.0.0.1"), 0});
      const auto port = static_cast<std::uint16_t>(first.local_endpoint().port() + 1);
      boost::system::error_code taken;
      Udp::socket second(loop_, Udp::v4());
      second.bind({boost::asio::ip::make_address("127.0.0.1"), port}, taken);
      if (taken || port == 0) continue;
      packets_ = std::move(first);
      control_ = std::move(second);
      packets_.non_blocking(true);
      control_.non_blocking(true);
      return;
    }
    throw std::runtime_error("no two free ports follow each other");
  }

  std::uint16_t port() const { return packets_.local_endpoint().port(); }
  void close() {
    packets_.close();
    control_.close();
  }

  /// nullopt: nothing came within the time.
  std::optional<std::vector<std::uint8_t>> next_packet(int most_ms = 5000) { return next(packets_, most_ms); }
  std::optional<std::vector<std::uint8_t>> next_control(int most_ms = 5000) {
    return next(control_, most_ms);
  }

  /// A picture: the payloads up to the packet with the marker. Empty: none came, or a packet is missing.
  std::vector<std::vector<std::uint8_t>> next_picture(int most_ms = 5000) {
    std::vector<std::vector<std::uint8_t>> payloads;
    while (const auto packet = next_packet(most_ms)) {
      const auto sequence = static_cast<std::uint16_t>((*packet)[2] << 8 | (*packet)[3]);
      const bool follows = !sequence_ || sequence == static_cast<std::uint16_t>(*sequence_ + 1);
      sequence_ = sequence;
      if (!follows) return {};
      timestamp_ = static_cast<std::uint32_t>((*packet)[4]) << 24 |
                   static_cast<std::uint32_t>((*packet)[5]) << 16 |
                   static_cast<std::uint32_t>((*packet)[6]) << 8 | (*packet)[7];
      payloads.emplace_back(packet->begin() + 12, packet->end());
      if (((*packet)[1] & 0x80) != 0) return payloads;
    }
    return {};
  }
  /// Of the last packet.
  std::uint32_t timestamp() const { return timestamp_; }

  /// To the sender of the last RTCP packet.
  void answer(const std::vector<std::uint8_t>& packet) {
    control_.send_to(boost::asio::buffer(packet), sender_);
  }

 private:
  std::optional<std::vector<std::uint8_t>> next(Udp::socket& socket, int most_ms) {
    std::vector<std::uint8_t> packet(2000);
    for (int waited_ms = 0; waited_ms <= most_ms; ++waited_ms) {
      boost::system::error_code nothing;
      Udp::endpoint from;
      const std::size_t bytes = socket.receive_from(boost::asio::buffer(packet), from, 0, nothing);
      if (!nothing) {
        if (&socket == &control_) sender_ = from;
        packet.erase(packet.begin() + static_cast<std::ptrdiff_t>(bytes), packet.end());
        return packet;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return std::nullopt;
  }

  boost::asio::io_context loop_;
  Udp::socket packets_{loop_};
  Udp::socket control_{loop_};
  Udp::endpoint sender_;
  std::optional<std::uint16_t> sequence_;
  std::uint32_t timestamp_ = 0;
};

}  // namespace fanlight::test
