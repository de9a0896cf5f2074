// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <netdb.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace fanlight {

/// The client's end of a TCP connection that is made again and again. No call blocks longer than its argument
/// says, also while a name is looked up. After connection it allocates nothing. One thread; a further one
/// looks up names, and outlives this object where the look-up hangs.
///
/// Sockets of the system, and not Asio's: Asio allocates memory for each wait that is begun outside of its
/// loop, and the acquisition thread has a loop of its own.
class IgtlSocket {
 public:
  IgtlSocket(std::string host, std::string port) : host_(std::move(host)), port_(std::move(port)) {}
  ~IgtlSocket() { close(); }
  IgtlSocket(const IgtlSocket&) = delete;
  IgtlSocket& operator=(const IgtlSocket&) = delete;

  bool is_open() const { return state_ == State::kOpen; }

  /// One step towards a connection, up to `most_ms`. True: the connection is open. False with trouble():
  /// this try has failed, and the next call begins another. Precondition: !is_open().
  bool connect_step(int most_ms);
  /// Why the last try failed: a part of a sentence. Empty: it has not.
  const std::string& trouble() const { return trouble_; }

  /// What is there, or comes within `most_ms`: the number of bytes written to `room`; 0: nothing came. The
  /// connection is closed where it has ended: !is_open(). Precondition: is_open() and room is not empty.
  std::size_t receive(std::span<std::uint8_t> room, int most_ms);

  /// Sends a message, whole or not at all: false where the other end has not taken the last ones. Small
  /// messages only.
  bool send(std::span<const std::uint8_t> message);

  void close();

 private:
  enum class State : std::uint8_t { kClosed, kLookingUp, kConnecting, kOpen };
  struct AddressList {
    void operator()(addrinfo* list) const { freeaddrinfo(list); }
  };
  struct LookUp {
    std::atomic<bool> done{false};
    int failure = 0;
    std::unique_ptr<addrinfo, AddressList> found;
  };

  void begin_look_up();
  bool look_up_step(int most_ms);
  void try_next_address();
  bool connecting_step(int most_ms);
  void fail(std::string trouble);
  void close_socket();
  void send_rest();

  std::string host_;
  std::string port_;
  State state_ = State::kClosed;
  std::shared_ptr<LookUp> look_up_;
  const addrinfo* next_ = nullptr;  // to be tried, of the look-up
  std::int64_t give_up_ns_ = 0;     // the present address
  int socket_ = -1;
  std::string trouble_;
  std::vector<std::uint8_t> unsent_;
};

}  // namespace fanlight
