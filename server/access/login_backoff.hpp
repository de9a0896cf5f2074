// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>

namespace fanlight {

/// Exponential back-off for failed logins, by address. After a failed attempt the next one is evaluated only
/// after one second, then after two, four, ... up to a minute. Ten minutes without a failure reset it. Keeps
/// guessing slow and its audit records few. One thread.
class LoginBackoff {
 public:
  /// Milliseconds until the next failed attempt of the address is evaluated; 0: now.
  std::int64_t wait_ms(const std::string& address, std::int64_t now_ms) const;

  void failed(const std::string& address, std::int64_t now_ms);

 private:
  struct Tries {
    int failed = 0;
    std::int64_t next_ms = 0;
    std::int64_t last_ms = 0;
  };
  std::unordered_map<std::string, Tries>
      tries_;  // bounded: a new address replaces the one with the oldest failure
};

}  // namespace fanlight
