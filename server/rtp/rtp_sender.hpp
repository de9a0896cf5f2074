// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "server/net/loop_chain.hpp"
#include "server/rtp/description_file.hpp"
#include "server/rtp/rtcp.hpp"
#include "server/rtp/rtp_clock.hpp"
#include "server/rtp/srtp_context.hpp"
#include "server/state/relay.hpp"
#include "server/state/server_state.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// Sends the pictures of the main view as RTP to one receiver, which serves them to many: an SFU such as
/// Janus (proto/RTP.md). They are encoded once, together with those of displays that ask for the same H.264.
/// Server thread only.
class RtpSender : public PictureSubscriber, public Relay {
 public:
  struct Config {
    std::string host;        ///< name or address of the receiver
    std::uint16_t port = 0;  ///< for RTP; RTCP goes to the next one
    int bit_rate_kbps = 4000;
    std::vector<std::uint8_t> srtp_key;  ///< kSrtpKeyBytes; empty: not encrypted
    std::filesystem::path sdp_file;      ///< empty: none is written
    bool at_start = false;               ///< sends from the start on, unasked
  };
  /// All must outlive this object.
  struct Dependencies {
    ServerState& state;
    PictureHub& hub;
    std::uint64_t id = 0;           ///< as a subscriber, never 0
    Executor executor;              ///< for files
    std::function<void()> changed;  ///< sending() has changed
  };
  RtpSender(boost::asio::io_context& loop, const Config& config, Dependencies dependencies);
  ~RtpSender() override;

  // Relay.
  /// Begins to send, with a key picture. kUnavailable: it sends already, or libsrtp refuses.
  Result<void> start() override;
  /// Tells the receiver that the stream ends.
  void stop() override;
  bool sending() const override { return sending_; }
  std::string to() const override;
  /// Its description: see sdp().
  RelayReport report() const override;

  /// Begins the chains again that a lack of memory has ended.
  void keep_alive();

  // PictureSubscriber.
  std::uint64_t id() const override { return dependencies_.id; }
  std::uint64_t view_id() const override { return 0; }
  void set_view(std::uint64_t) override {}
  const StreamSettings& settings() const override { return settings_; }
  bool privileged() const override { return true; }
  void offer(const PictureOffer& picture) override;
  void encoding_failed() override;

 private:
  using Udp = boost::asio::ip::udp;

  bool encrypted() const { return !config_.srtp_key.empty(); }
  void resolve();
  void resolved(boost::system::error_code failure, const Udp::resolver::results_type& found);
  bool reaches_one_of(const Udp::resolver::results_type& found) const;
  Result<void> connect(const Udp::endpoint& receiver);
  void close();
  void tick();
  void ticked();
  void receive();
  void received(std::size_t bytes);
  bool is_plausible(const RtcpFeedback& feedback) const;
  void believe(const RtcpFeedback& feedback);
  void report_ourselves(bool ends);
  void send_units(std::span<const std::span<const std::uint8_t>> units, std::uint32_t timestamp);
  bool send(Udp::socket& socket, const std::vector<std::uint8_t>& packet);
  void describe(std::span<const std::span<const std::uint8_t>> units);

  Config config_;
  Dependencies dependencies_;
  DescriptionFile file_;
  StreamSettings settings_;
  Udp::resolver resolver_;
  Udp::socket packets_;  // RTP
  Udp::socket control_;  // RTCP
  boost::asio::steady_timer pause_;
  LoopChain tick_chain_;
  LoopChain receive_chain_;
  LoopChain resolve_chain_;
  std::unique_ptr<SrtpContext> srtp_;  // nullptr: not encrypted
  bool sending_ = false;
  bool complained_ = false;   // of a receiver that does not answer, or has no address
  bool wants_key_ = false;    // a picture went out cut, or the receiver is new
  std::uint32_t source_ = 0;  // SSRC
  std::uint16_t sequence_ = 0;
  RtpClock clock_;
  std::uint64_t connection_ = 0;  // counts the receivers that this object was connected to
  std::uint64_t session_ = 0;
  std::uint64_t last_picture_id_ = 0;
  std::uint32_t packets_sent_ = 0;
  std::uint32_t payload_bytes_sent_ = 0;
  std::int64_t key_sent_ns_ = 0;
  std::int64_t report_due_ns_ = 0;
  std::int64_t resolved_ns_ = 0;
  std::int64_t heard_ns_ = 0;  // of the receiver
  std::int64_t reported_ns_ = 0;
  ReceptionReport report_;
  bool has_report_ = false;
  std::array<std::uint8_t, 1500> incoming_{};
  std::vector<std::uint8_t> packet_;
  std::vector<std::uint8_t> sequence_set_;
  std::vector<std::uint8_t> picture_set_;
  std::string description_;
  std::uint64_t description_version_ = 0;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
