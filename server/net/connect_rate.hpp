// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <string>

namespace fanlight {

/// Paces new connections with TLS, whose handshakes cost the server a millisecond each. Pure logic: the owner
/// calls refill() once a second.
class ConnectRate {
 public:
  static constexpr std::size_t kASecond = 100;
  static constexpr std::size_t kAHostASecond = 20;

  /// A second has passed.
  void refill() {
    taken_ = 0;
    by_host_.clear();
  }

  /// Whether another connection may be accepted within this second. Until then they wait in the system.
  bool may_accept() const { return taken_ < kASecond; }

  /// Counts a connection; false if its host has had its share of this second. `host`: as
  /// ConnectionLimit::host_of(); loopback has no share of its own.
  bool take(const std::string& host) {
    ++taken_;
    return host.empty() || ++by_host_[host] <= kAHostASecond;
  }

 private:
  std::size_t taken_ = 0;
  std::map<std::string, std::size_t> by_host_;  // at most kASecond
};

}  // namespace fanlight
