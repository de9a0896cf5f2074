// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "proto/igtl/message_reader.hpp"
#include "proto/igtl/message_writer.hpp"
#include "proto/igtl/opened_message.hpp"
#include "proto/igtl/text_bodies.hpp"
#include "server/access/role.hpp"
#include "server/igtl/igtl_commands.hpp"
#include "server/igtl/igtl_outbox.hpp"
#include "server/igtl/igtl_state.hpp"
#include "server/igtl/igtl_streams.hpp"
#include "server/igtl/stream_message.hpp"
#include "server/net/connection_limit.hpp"
#include "server/net/send_progress.hpp"
#include "server/state/server_counters.hpp"

namespace fanlight {

/// One OpenIGTLink client: what it asks for, and what it is sent. At most one read and one write are under
/// way. Messages of streams wait in an IgtlOutbox: a client that reads slowly loses its own messages only.
/// One that acknowledges no byte for five seconds is disconnected, and so is one that takes too long for the
/// head of a message, or that has sent no message and is sent none of a stream for too long (Patience). A
/// client that has sent no message gives its place to a newer one where all are taken (ConnectionLimit).
/// Server thread only; the pending operations keep it alive.
///
/// It is answered in the version of the header that it uses itself, and in version 1 until it has sent
/// anything.
class IgtlSession : public std::enable_shared_from_this<IgtlSession> {
 public:
  /// How long a client is waited for.
  struct Patience {
    int head_s = 10;   ///< from the first byte of a head to its last one
    int idle_s = 600;  ///< without a message in either direction, except STATUS of ours
  };
  struct Dependencies {
    ServerCounters& counters;
    IgtlCommands& commands;
    std::function<IgtlState()> state;  ///< of the picture
    std::function<void()> asked;       ///< a message of a stream is wanted now
    std::function<void()> wants_changed;
    std::size_t& bytes_waiting;  ///< of all sessions; see IgtlOutbox
    std::function<void(IgtlSession&)> left;
  };
  struct Config {
    IgtlStreams usual;                ///< sent to a client that asks for nothing
    std::uint32_t most_messages = 0;  ///< that are read of it in a second
    Patience patience{};
  };
  /// `dependencies` must outlive the session.
  IgtlSession(boost::asio::ip::tcp::socket socket, ConnectionPermit permit, Principal principal,
              const Config& config, const Dependencies& dependencies);

  void start();

  igtl::HeadVersion version() const { return version_; }
  /// The streams that it is sent, and those of which it waits for one message.
  const IgtlStreams& wanted() const { return wanted_; }
  /// Of those, what it was not yet sent of this picture and its volume, or asks for once more. Not frames.
  IgtlStreams wanted_of(std::uint64_t picture_id, std::uint64_t volume_id) const;
  /// Whether it waits for a picture of the video that needs none before it.
  bool needs_key_picture() const { return wanted_.has(IgtlStream::kVideo) && outbox_.needs_key_picture(); }
  const std::string& address() const { return principal_.address; }

  /// A new message of a stream; see IgtlOutbox. `id`: of the picture or volume that it shows. `key`: of the
  /// video, a picture that needs none before it. Ignored where the client does not want it.
  void offer(IgtlStream stream, const IgtlMessage& message, std::uint64_t id = 0, bool key = true);
  /// A volume that was ordered for one id, and shows perhaps a newer one.
  void offer_volume(const IgtlMessage& message, std::uint64_t ordered_id, std::uint64_t shown_id);
  /// There is no message of this stream: an empty one for who has asked for one, a STATUS for who has started
  /// the stream.
  void not_available(IgtlStream stream, const std::string& why);
  /// Sends the state of the picture.
  void send_status();

  void second_passed();
  /// Says that the server ends, and closes once that is sent.
  void end();
  /// Closes at once.
  void leave();
  bool is_gone() const { return gone_; }

 private:
  void read();
  void received(std::size_t bytes);
  void close_for(Counter& counter, const std::string& why);
  void take_message();
  void take_query(const igtl::QueryType& query, const igtl::OpenedMessage& opened);
  void want(IgtlStream stream, IgtlStreams& whether);
  void start_stream(const igtl::QueryType& query, const igtl::OpenedMessage& opened);
  void stop_streams(const igtl::QueryType& query);
  void answer_query(std::string_view type, bool good);
  void take_command(const igtl::OpenedMessage& opened);
  void refuse_command(std::uint32_t id, const std::string& why);
  void take_string(const igtl::OpenedMessage& opened);
  bool is_repeated(std::string_view id);
  void answer(const igtl::Envelope& envelope, const std::function<void(std::vector<std::uint8_t>&)>& put);
  bool has_of(IgtlStream stream, std::uint64_t id) const;
  bool has_room() const { return answers_.size() < kMostAnswers; }
  bool may_read() const {
    return !gone_ && !ending_ && !reading_ && has_room() && messages_ < most_messages_;
  }
  void wants_changed();
  void pump();
  IgtlMessage next();
  void written(std::size_t bytes);

  static constexpr std::size_t kMostAnswers = 16;
  static constexpr std::size_t kRepeats = 10;

  boost::asio::ip::tcp::socket socket_;
  std::optional<ConnectionPermit> permit_;  // until it leaves
  Principal principal_;
  const Dependencies& dependencies_;
  igtl::MessageReader reader_;
  igtl::MessageWriter writer_;
  igtl::HeadVersion version_ = igtl::HeadVersion::kOne;
  IgtlStreams started_;     // it is sent again and again
  IgtlStreams once_;        // it has asked for one message
  IgtlStreams wanted_;      // both
  bool has_asked_ = false;  // for a stream: it gets what it asks for, and not what is usual
  // Id of the newest picture or volume that was offered of each; 0: none.
  std::array<std::uint64_t, kIgtlStreams> sent_of_{};
  std::uint64_t volume_ordered_ = 0;  // for which id the newest volume was sent: its own may be higher
  std::uint32_t most_messages_;
  Patience patience_;
  bool is_heard_ = false;  // it has sent a message
  int seconds_in_head_ = 0;
  int seconds_idle_ = 0;
  std::uint32_t messages_ = 0;  // in this second
  IgtlOutbox outbox_;
  std::deque<IgtlMessage> answers_;
  std::array<std::string, kRepeats> repeats_;  // ids of the last commands
  std::size_t repeat_at_ = 0;
  IgtlMessage under_way_;
  bool under_way_counts_ = false;  // it is a message of a stream
  bool reading_ = false;
  bool ending_ = false;
  bool gone_ = false;
  SendProgress progress_;
};

}  // namespace fanlight
