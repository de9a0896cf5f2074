// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/address.hpp>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace fanlight {

class ConnectionLimit;

/// The permit for one connection. It counts against the limit until it is destroyed.
class ConnectionPermit {
 public:
  ConnectionPermit(ConnectionLimit& limit, std::string host) : limit_(&limit), host_(std::move(host)) {}
  ConnectionPermit(ConnectionPermit&& other) noexcept
      : limit_(std::exchange(other.limit_, nullptr)), host_(std::move(other.host_)) {}
  ConnectionPermit& operator=(ConnectionPermit&&) = delete;
  ~ConnectionPermit();

 private:
  ConnectionLimit* limit_;
  std::string host_;
};

/// Limits the number of connections, in all and from one address, so that one peer cannot use up all of them.
/// The limit for one address does not apply to the loopback address, where a proxy may run. Must outlive its
/// permits. Server thread only.
class ConnectionLimit {
 public:
  ConnectionLimit(std::size_t most, std::size_t most_a_host) : most_(most), most_a_host_(most_a_host) {}

  /// nullopt if a limit is reached.
  std::optional<ConnectionPermit> take(const boost::asio::ip::address& address) {
    const std::string host = address.is_loopback() ? "" : address.to_string();
    const auto known = by_host_.find(host);
    if (taken_ >= most_ || (!host.empty() && known != by_host_.end() && known->second >= most_a_host_))
      return std::nullopt;
    ++taken_;
    ++by_host_[host];
    return std::optional<ConnectionPermit>(std::in_place, *this, host);
  }

 private:
  friend class ConnectionPermit;
  void give_back(const std::string& host) {
    --taken_;
    const auto known = by_host_.find(host);
    if (--known->second == 0) by_host_.erase(known);
  }

  std::size_t most_;
  std::size_t most_a_host_;
  std::size_t taken_ = 0;
  std::map<std::string, std::size_t> by_host_;
};

inline ConnectionPermit::~ConnectionPermit() {
  if (limit_ != nullptr) limit_->give_back(host_);
}

}  // namespace fanlight
