// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/private_share.hpp"

#include <utility>

#include "proto/exchange/private_view.hpp"

namespace fanlight {

bool PrivateShare::is_turn(bool due, bool main_busy, std::int64_t now_ns) {
  if (!turn_) {
    if (!due || now_ns < main_until_ns_) return false;
    turn_ = true;
    turn_ns_ = now_ns;
    private_ns_ = 0;
  }
  if (!main_busy && private_ns_ == 0) private_ns_ = now_ns;
  if (!due || now_ns - turn_ns_ > kLongestTurnNs) end_turn(now_ns);
  return turn_;
}

void PrivateShare::end_turn(std::int64_t now_ns) {
  if (!std::exchange(turn_, false)) return;
  const std::int64_t taken_ns = private_ns_ == 0 ? 0 : now_ns - private_ns_;
  main_until_ns_ = now_ns + kMainTimes * taken_ns;
}

}  // namespace fanlight
