// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/igtl_socket.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>
#include <utility>

#include "proto/base/clock.hpp"

namespace fanlight {

namespace {

constexpr std::int64_t kMostConnectNs = 3'000'000'000;  // for each address
constexpr std::size_t kMostUnsentBytes = 4096;
constexpr int kReceiveBytes = 4 << 20;

std::string reason(int failure) {
  return std::generic_category().message(failure);
}

addrinfo wanted(int flags) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags;
  return hints;
}

/// Whether the socket is ready for `events` within the time.
bool is_ready(int socket, short events, int most_ms) {
  pollfd waiting{.fd = socket, .events = events, .revents = 0};
  return poll(&waiting, 1, most_ms) > 0;
}

}  // namespace

bool IgtlSocket::connect_step(int most_ms) {
  trouble_.clear();
  if (state_ == State::kClosed) begin_look_up();
  if (state_ == State::kLookingUp && !look_up_step(most_ms)) return false;
  return connecting_step(most_ms);
}

void IgtlSocket::begin_look_up() {
  state_ = State::kLookingUp;
  look_up_ = std::make_shared<LookUp>();
  addrinfo* found = nullptr;
  const addrinfo numeric = wanted(AI_NUMERICHOST | AI_NUMERICSERV);
  if (getaddrinfo(host_.c_str(), port_.c_str(), &numeric, &found) == 0) {
    look_up_->found.reset(found);
    look_up_->done.store(true, std::memory_order_release);
    return;
  }
  // A server for names that does not answer must not stop the caller.
  const auto look = [look_up = look_up_, host = host_, port = port_] {
    addrinfo* list = nullptr;
    const addrinfo named = wanted(AI_NUMERICSERV);
    look_up->failure = getaddrinfo(host.c_str(), port.c_str(), &named, &list);
    look_up->found.reset(look_up->failure == 0 ? list : nullptr);
    look_up->done.store(true, std::memory_order_release);
  };
  try {
    std::thread(look).detach();
  } catch (const std::system_error&) {
    look_up_->failure = EAI_AGAIN;  // the system makes no thread now
    look_up_->done.store(true, std::memory_order_release);
  }
}

bool IgtlSocket::look_up_step(int most_ms) {
  if (!look_up_->done.load(std::memory_order_acquire)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(most_ms));
    return false;
  }
  next_ = look_up_->found.get();
  if (next_ == nullptr) {
    fail("its name is not found: " + std::string(gai_strerror(look_up_->failure)));
    return false;
  }
  try_next_address();
  return state_ == State::kConnecting;
}

/// Begins to connect to the next address that takes it; without one, the try has failed.
void IgtlSocket::try_next_address() {
  int failure = EADDRNOTAVAIL;
  while (next_ != nullptr) {
    const addrinfo* const address = std::exchange(next_, next_->ai_next);
    close_socket();
    socket_ = socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, address->ai_protocol);
    if (socket_ < 0) {
      failure = errno;
      continue;
    }
    // The kernel then takes a whole frame while the last one is rendered. It may give less.
    setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &kReceiveBytes, sizeof(kReceiveBytes));
    const int on = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
    if (connect(socket_, address->ai_addr, address->ai_addrlen) == 0 || errno == EINPROGRESS) {
      state_ = State::kConnecting;
      give_up_ns_ = now_ns() + kMostConnectNs;
      return;
    }
    failure = errno;
  }
  fail(reason(failure));
}

bool IgtlSocket::connecting_step(int most_ms) {
  int failure = ETIMEDOUT;
  if (is_ready(socket_, POLLOUT, most_ms)) {
    socklen_t size = sizeof(failure);
    if (getsockopt(socket_, SOL_SOCKET, SO_ERROR, &failure, &size) != 0) failure = errno;
  } else if (now_ns() < give_up_ns_) {
    return false;
  }
  if (failure == 0) {
    state_ = State::kOpen;
    unsent_.clear();
    unsent_.reserve(kMostUnsentBytes);
    return true;
  }
  if (next_ != nullptr) {
    try_next_address();
  } else {
    fail(reason(failure));
  }
  return false;
}

std::size_t IgtlSocket::receive(std::span<std::uint8_t> room, int most_ms) {
  if (!unsent_.empty()) send_rest();
  for (bool waited = false;; waited = true) {
    const ssize_t bytes = recv(socket_, room.data(), room.size(), 0);
    if (bytes > 0) return static_cast<std::size_t>(bytes);
    const bool nothing_yet = bytes < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
    if (!nothing_yet) {
      fail(bytes == 0 ? "the other end closed the connection" : reason(errno));
      return 0;
    }
    if (waited || !is_ready(socket_, POLLIN, most_ms)) return 0;
  }
}

bool IgtlSocket::send(std::span<const std::uint8_t> message) {
  if (!is_open() || unsent_.size() + message.size() > kMostUnsentBytes) return false;
  unsent_.insert(unsent_.end(), message.begin(), message.end());
  send_rest();
  return true;
}

/// A failure shows when the next bytes are received.
void IgtlSocket::send_rest() {
  const ssize_t sent = ::send(socket_, unsent_.data(), unsent_.size(), MSG_NOSIGNAL);
  if (sent > 0) unsent_.erase(unsent_.begin(), unsent_.begin() + sent);
}

void IgtlSocket::fail(std::string trouble) {
  close();
  trouble_ = std::move(trouble);
}

void IgtlSocket::close() {
  close_socket();
  state_ = State::kClosed;
  next_ = nullptr;
  look_up_ = nullptr;
}

void IgtlSocket::close_socket() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

}  // namespace fanlight
