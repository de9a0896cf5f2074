#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>

namespace fanlight {

/// Makes guessing slow: after a failed try an address waits a second, after the next two, four, ... up to a
/// minute, and what it tries meanwhile is refused unread. A success, or ten quiet minutes, wipe the slate.
/// One thread.
class LoginGuard {
 public:
  /// Milliseconds until the address may try; 0: now.
  std::int64_t wait_ms(const std::string& address, std::int64_t now_ms) const;

  void failed(const std::string& address, std::int64_t now_ms);
  void succeeded(const std::string& address) { tries_.erase(address); }

 private:
  struct Tries {
    int failed = 0;
    std::int64_t next_ms = 0;
    std::int64_t last_ms = 0;
  };
  std::unordered_map<std::string, Tries> tries_;  // bounded: the stalest makes room
};

}  // namespace fanlight
