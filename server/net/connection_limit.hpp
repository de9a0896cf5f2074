// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/address.hpp>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>

#include "proto/base/thread_owner.hpp"

namespace fanlight {

class ConnectionLimit;

/// The permit for one connection. It counts against the limit until it is destroyed. Server thread only.
class ConnectionPermit {
 public:
  ConnectionPermit(ConnectionPermit&& other) noexcept;
  ConnectionPermit& operator=(ConnectionPermit&&) = delete;
  ~ConnectionPermit();

  /// What closes the connection, where its place is needed for another one. Called at most once.
  void on_eviction(std::function<void()> close);

  /// The client has shown credentials that are valid, or where there are none, has made itself known: its
  /// place is its own from now on. Its host counts as known.
  void authenticated();

 private:
  friend class ConnectionLimit;
  struct Place {
    std::string host;
    bool anonymous = true;
    bool is_known = false;  ///< another client of its host was authenticated before
    std::function<void()> close;
  };
  using Position = std::list<Place>::iterator;
  ConnectionPermit(ConnectionLimit& limit, Position place) : limit_(&limit), place_(place) {}

  ConnectionLimit* limit_;
  Position place_;
};

/// Limits the number of connections: in all, of one host, and of anonymous clients, which have not shown
/// valid credentials. Anonymous clients of unknown hosts have three quarters of the places, those of loopback
/// and of known hosts, together with them, seven eighths. Where a share is full, the oldest anonymous client
/// loses its place to a new one, so that neither slow logins nor idle clients keep people out. The limit for
/// one host does not apply to the loopback address, where a proxy may run. A host is an IPv4 address, or the
/// first 64 bits of an IPv6 address, which is what one customer has; it is known when a client of it was
/// authenticated. Must outlive its permits. Server thread only.
class ConnectionLimit {
 public:
  ConnectionLimit(std::size_t most, std::size_t most_a_host) : most_(most), most_a_host_(most_a_host) {}

  /// nullopt if a limit is reached and no connection can make room.
  std::optional<ConnectionPermit> take(const boost::asio::ip::address& address);

  /// The host that an address belongs to; empty for loopback.
  static std::string host_of(const boost::asio::ip::address& address);

  /// Anonymous clients that lost their place, since the start.
  std::size_t evicted() const { return evicted_; }

 private:
  friend class ConnectionPermit;
  using Place = ConnectionPermit::Place;
  std::size_t most_unknown() const { return most_ - most_ / 4; }
  std::size_t most_anonymous() const { return most_ - most_ / 8; }
  bool evict_oldest(bool unknown_only);
  void note_known(const std::string& host);
  void give_back(ConnectionPermit::Position place);
  void leave_anonymous(Place& place);

  std::size_t most_;
  std::size_t most_a_host_;
  std::list<Place> places_;  // oldest first
  // Of anonymous clients, without those that were asked to close: of unknown hosts, and all.
  std::size_t unknown_ = 0;
  std::size_t anonymous_ = 0;
  std::list<std::string> known_;  // hosts, the newest last
  std::map<std::string, std::size_t> by_host_;
  std::size_t evicted_ = 0;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

/// Open files besides connections: the GPU's, the source's, the logs.
inline constexpr std::size_t kOtherFiles = 64;

/// The number of connections, at most `connections`, for which the process has file descriptors. Raises the
/// limit of the process as far as possible, and keeps some descriptors for files.
std::size_t connections_within_limit(std::size_t connections);

}  // namespace fanlight
