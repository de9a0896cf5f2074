#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>

namespace fanlight {

/// Makes guessing slow, and its record short: after a failed try the next counts only after a second, then
/// after two, four, ... up to a minute. Ten quiet minutes wipe the slate. One thread.
class LoginGuard {
 public:
  /// Milliseconds until another failure of the address is looked at; 0: now.
  std::int64_t wait_ms(const std::string& address, std::int64_t now_ms) const;

  void failed(const std::string& address, std::int64_t now_ms);

 private:
  struct Tries {
    int failed = 0;
    std::int64_t next_ms = 0;
    std::int64_t last_ms = 0;
  };
  std::unordered_map<std::string, Tries> tries_;  // bounded: the stalest makes room
};

}  // namespace fanlight
