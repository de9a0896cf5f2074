// SPDX-License-Identifier: Apache-2.0
#include "server/cli/rtp_options.hpp"

#include <fmt/format.h>

#include <boost/asio/ip/address.hpp>
#include <charconv>
#include <string_view>

#include "proto/base/printable.hpp"
#include "server/rtp/srtp_context.hpp"

namespace fanlight {

namespace {

struct Receiver {
  std::string host;
  std::uint16_t port = 0;
};

/// "HOST:PORT" or "[ADDRESS]:PORT"; the port leaves room for the next one, of RTCP.
std::optional<Receiver> parse_receiver(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  std::string_view host = text.substr(0, colon);
  const std::string_view port_text = text.substr(colon + 1);
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  std::uint16_t port = 0;
  const auto [end, failure] = std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  const bool good_port =
      failure == std::errc{} && end == port_text.data() + port_text.size() && port >= 1 && port < 65535;
  const bool good_host = !host.empty() && host.size() <= 253 && host.find(' ') == std::string_view::npos &&
                         (bracketed || host.find(':') == std::string_view::npos);
  if (!good_port || !good_host) return std::nullopt;
  return Receiver{std::string(host), port};
}

bool is_this_machine(const std::string& host) {
  boost::system::error_code none;
  const auto address = boost::asio::ip::make_address(host, none);
  return none ? host == "localhost" : address.is_loopback();
}

/// Its many receivers would report to one sender at once, and no SFU needs it.
bool is_multicast(const std::string& host) {
  boost::system::error_code none;
  const auto address = boost::asio::ip::make_address(host, none);
  return !none && address.is_multicast();
}

}  // namespace

void RtpOptions::add_to(CLI::App& command) {
  command.option_defaults()->group("Pictures by RTP");
  command
      .add_option("--rtp-to", to,
                  "HOST:PORT of a receiver to which an admin may send the pictures: an SFU such as Janus, "
                  "for displays outside the "
                  "room; RTP goes to this port, RTCP to the next one; default: nowhere")
      ->type_name("RECEIVER");
  command.add_flag("--rtp-start", start,
                   "Start sending at once; otherwise an admin starts it with POST /api/rtp");
  command
      .add_option(
          "--rtp-key", key,
          "File with 30 random bytes in base64, the SRTP key (AES_CM_128_HMAC_SHA1_80); required for a "
          "receiver on another machine")
      ->type_name("FILE");
  command
      .add_option("--rtp-sdp", sdp,
                  "File for the SDP of the stream, for its receiver; exists while the stream is sent")
      ->type_name("FILE");
  command.add_option("--rtp-kbps", kbps, "Bit rate of the video, kbit/s")
      ->capture_default_str()
      ->check(CLI::Range(100, 50'000))
      ->type_name("KBPS");
}

Result<std::optional<RtpSender::Config>> RtpOptions::config() const {
  if (to.empty()) {
    // Not by the parser: a configuration may have each of them with its default.
    const RtpOptions usual;
    const char* const given = start                ? "--rtp-start"
                              : !key.empty()       ? "--rtp-key"
                              : !sdp.empty()       ? "--rtp-sdp"
                              : kbps != usual.kbps ? "--rtp-kbps"
                                                   : nullptr;
    if (given == nullptr) return std::optional<RtpSender::Config>();
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} needs --rtp-to, expected a receiver such as 127.0.0.1:5004 there", given)};
  }
  const auto receiver = parse_receiver(to);
  if (!receiver) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("--rtp-to {} is no receiver, expected HOST:PORT such as 127.0.0.1:5004, "
                             "janus.example:5004 or [::1]:5004, with a port from 1 to 65534",
                             printable(to))};
  }
  if (is_multicast(receiver->host)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("--rtp-to {} is a multicast address, expected one receiver", printable(to))};
  }
  if (key.empty() && !is_this_machine(receiver->host)) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("--rtp-to {} would send the pictures over a network for everyone on it to see; expected "
                    "--rtp-key with a key for SRTP, or a receiver on this machine",
                    printable(to))};
  }
  RtpSender::Config config{.host = receiver->host, .port = receiver->port, .bit_rate_kbps = kbps};
  config.sdp_file = sdp;
  config.at_start = start;
  if (!key.empty()) {
    auto read = read_srtp_key(key);
    if (!read) return Error{read.error().code, "--rtp-key: " + read.error().message};
    config.srtp_key = *std::move(read);
  }
  return std::optional(std::move(config));
}

}  // namespace fanlight
