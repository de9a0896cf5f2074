// SPDX-License-Identifier: Apache-2.0
#include "server/access/login_backoff.hpp"

#include <algorithm>

namespace fanlight {

namespace {

constexpr std::size_t kMostAddresses = 4096;
constexpr std::int64_t kFirstWaitMs = 1000;
constexpr std::int64_t kLongestWaitMs = 60'000;
constexpr std::int64_t kForgottenMs = 600'000;
constexpr int kMostDoublings = 6;

}  // namespace

std::int64_t LoginBackoff::wait_ms(const std::string& address, std::int64_t now_ms) const {
  const auto found = tries_.find(address);
  if (found == tries_.end()) return 0;
  return std::max<std::int64_t>(found->second.next_ms - now_ms, 0);
}

void LoginBackoff::failed(const std::string& address, std::int64_t now_ms) {
  if (tries_.size() >= kMostAddresses && !tries_.contains(address)) {
    const auto stalest =
        std::ranges::min_element(tries_, {}, [](const auto& entry) { return entry.second.last_ms; });
    tries_.erase(stalest);
  }
  Tries& tries = tries_[address];
  if (now_ms - tries.last_ms > kForgottenMs) tries.failed = 0;
  const std::int64_t wait = kFirstWaitMs << std::min(tries.failed, kMostDoublings);
  ++tries.failed;
  tries.last_ms = now_ms;
  tries.next_ms = now_ms + std::min(wait, kLongestWaitMs);
}

}  // namespace fanlight
