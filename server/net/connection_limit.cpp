// SPDX-License-Identifier: Apache-2.0
#include "server/net/connection_limit.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

namespace fanlight {

namespace asio = boost::asio;

ConnectionPermit::ConnectionPermit(ConnectionPermit&& other) noexcept
    : limit_(std::exchange(other.limit_, nullptr)), place_(other.place_) {}

ConnectionPermit::~ConnectionPermit() {
  if (limit_ != nullptr) limit_->give_back(place_);
}

void ConnectionPermit::on_eviction(std::function<void()> close) {
  if (limit_ != nullptr) place_->close = std::move(close);
}

void ConnectionPermit::authenticated() {
  if (limit_ == nullptr) return;
  limit_->note_known(place_->host);
  limit_->leave_anonymous(*place_);
}

std::string ConnectionLimit::host_of(const asio::ip::address& address) {
  if (address.is_loopback()) return "";
  if (!address.is_v6()) return address.to_string();
  const asio::ip::address_v6 v6 = address.to_v6();
  if (v6.is_v4_mapped()) return host_of(asio::ip::make_address_v4(asio::ip::v4_mapped, v6));
  auto bytes = v6.to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), std::uint8_t{0});
  return asio::ip::address_v6(bytes).to_string() + "/64";
}

std::optional<ConnectionPermit> ConnectionLimit::take(const asio::ip::address& address) {
  thread_owner_.check();
  const std::string host = host_of(address);
  const bool loopback = host.empty();
  const auto of_host = by_host_.find(host);
  if (!loopback && of_host != by_host_.end() && of_host->second >= most_a_host_) return std::nullopt;
  const bool is_known = loopback || std::ranges::find(known_, host) != known_.end();
  // A place that is asked to close is free only when its connection has ended.
  if (!is_known && unknown_ >= most_unknown() && !evict_oldest(true)) return std::nullopt;
  if (anonymous_ >= most_anonymous() && !evict_oldest(false)) return std::nullopt;
  // Clients with places of their own may leave the others less than their shares.
  if (places_.size() >= most_ && !evict_oldest(true)) evict_oldest(false);
  if (places_.size() >= most_) return std::nullopt;
  ++by_host_[host];
  ++anonymous_;
  unknown_ += is_known ? 0 : 1;
  places_.push_back({.host = host, .anonymous = true, .is_known = is_known, .close = nullptr});
  return ConnectionPermit(*this, std::prev(places_.end()));
}

/// Of unknown hosts alone, or of all anonymous clients.
bool ConnectionLimit::evict_oldest(bool unknown_only) {
  const auto oldest = std::ranges::find_if(places_, [unknown_only](const Place& place) {
    return place.anonymous && place.close != nullptr && !(unknown_only && place.is_known);
  });
  if (oldest == places_.end()) return false;
  leave_anonymous(*oldest);
  ++evicted_;
  std::exchange(oldest->close, nullptr)();
  return true;
}

void ConnectionLimit::note_known(const std::string& host) {
  constexpr std::size_t kMostKnown = 1024;
  if (host.empty()) return;  // loopback always is
  const auto before = std::ranges::find(known_, host);
  if (before != known_.end()) known_.erase(before);
  known_.push_back(host);
  if (known_.size() > kMostKnown) known_.pop_front();
}

void ConnectionLimit::leave_anonymous(Place& place) {
  if (!std::exchange(place.anonymous, false)) return;
  --anonymous_;
  unknown_ -= place.is_known ? 0 : 1;
}

void ConnectionLimit::give_back(ConnectionPermit::Position place) {
  leave_anonymous(*place);
  const auto known = by_host_.find(place->host);
  if (--known->second == 0) by_host_.erase(known);
  places_.erase(place);
}

std::size_t connections_within_limit(std::size_t connections) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return connections;
  limit.rlim_cur = std::max(limit.rlim_cur, std::min<rlim_t>(limit.rlim_max, connections + kOtherFiles));
  setrlimit(RLIMIT_NOFILE, &limit);
  getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur > kOtherFiles ? limit.rlim_cur - kOtherFiles : 1;
}

}  // namespace fanlight
