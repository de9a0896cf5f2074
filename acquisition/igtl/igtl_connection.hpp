// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/igtl/igtl_address.hpp"
#include "acquisition/igtl/igtl_socket.hpp"
#include "proto/exchange/probe_link.hpp"
#include "proto/igtl/message_reader.hpp"
#include "proto/igtl/message_writer.hpp"

namespace fanlight {

/// The messages of an OpenIGTLink server: connects, requests images and poses, tells the server that it is
/// alive, and connects again where the connection is lost or silent. Publishes kLost meanwhile. One thread.
/// No call blocks longer than 20 ms.
class IgtlConnection {
 public:
  /// `silence_s`: a server from which nothing comes for so long is given up. `link` must outlive this object.
  IgtlConnection(const IgtlAddress& address, double silence_s, ProbeLink& link);

  enum class Event : std::uint8_t {
    kNothing,  ///< no message is whole
    kMessage,  ///< head() and body() have one; the body is valid until the next call of step()
  };
  /// One step: of connecting, or of a message. Counts what is wrong with the stream.
  Event step();

  bool is_open() const { return socket_.is_open(); }
  /// Counts the connections that were made, from 1.
  std::uint64_t number() const { return number_; }
  /// Why there is none; empty: there is, or none was tried yet.
  const std::string& trouble() const { return status_.trouble; }

  const igtl::MessageHead& head() const { return reader_.head(); }
  std::span<const std::uint8_t> body() const { return reader_.body(); }
  /// See MessageReader::swap_body().
  void swap_body(std::vector<std::uint8_t>& memory) { reader_.swap_body(memory); }

  /// Says why nothing is shown although the connection is open.
  void report_trouble(const std::string& trouble) { publish(status_.state, trouble); }

  /// Where the frames come from, as the newest one says; absent: it does not.
  void report_origin(std::optional<FrameOrigin> origin) {
    if (status_.origin != origin) publish(status_.state, status_.trouble, origin);
  }

  /// Answers GET_CAPABIL.
  void send_capability();

 private:
  void connect();
  void connected();
  Event receive();
  void lose(const std::string& why);
  void say_alive();
  void ask_for_images(igtl::HeadVersion version);
  void ask_for_poses();
  void ask_in_version_2();
  void publish(ProbeStatus::State state, const std::string& trouble) {
    publish(state, trouble, status_.origin);
  }
  void publish(ProbeStatus::State state, const std::string& trouble, std::optional<FrameOrigin> origin);

  IgtlAddress address_;
  std::int64_t silence_ns_;
  ProbeLink& link_;
  IgtlCounters& counters_;
  IgtlSocket socket_;
  igtl::MessageReader reader_;
  igtl::MessageWriter writer_;
  std::uint64_t number_ = 0;
  std::int64_t next_try_ns_ = 0;
  std::int64_t pause_ns_ = 0;  // before the next try
  std::int64_t heard_ns_ = 0;  // when the last bytes came
  std::int64_t said_alive_ns_ = 0;
  bool knows_version_2_ = false;  // this connection's other end
  ProbeStatus status_;
};

}  // namespace fanlight
