#pragma once

#include <boost/asio/ip/address.hpp>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace fanlight {

class ConnectionPlaces;

/// One of the connections that a server allows at once, counted while it lives.
class ConnectionPlace {
 public:
  ConnectionPlace(ConnectionPlaces& places, std::string host) : places_(&places), host_(std::move(host)) {}
  ConnectionPlace(ConnectionPlace&& other) noexcept
      : places_(std::exchange(other.places_, nullptr)), host_(std::move(other.host_)) {}
  ConnectionPlace& operator=(ConnectionPlace&&) = delete;
  ~ConnectionPlace();

 private:
  ConnectionPlaces* places_;
  std::string host_;
};

/// How many connections there may be, in all and from one address: one peer cannot take all of them, unless
/// it is this machine, where a proxy may stand. Outlives its places. Server thread only.
class ConnectionPlaces {
 public:
  ConnectionPlaces(std::size_t most, std::size_t most_a_host) : most_(most), most_a_host_(most_a_host) {}

  /// None where there are as many already.
  std::optional<ConnectionPlace> take(const boost::asio::ip::address& address) {
    const std::string host = address.is_loopback() ? "" : address.to_string();
    const auto known = by_host_.find(host);
    if (taken_ >= most_ || (!host.empty() && known != by_host_.end() && known->second >= most_a_host_))
      return std::nullopt;
    ++taken_;
    ++by_host_[host];
    return std::optional<ConnectionPlace>(std::in_place, *this, host);
  }

 private:
  friend class ConnectionPlace;
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

inline ConnectionPlace::~ConnectionPlace() {
  if (places_ != nullptr) places_->give_back(host_);
}

}  // namespace fanlight
