// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace fanlight {

/// Gives the private views a share of the time where the main view would take all of it. They have turns:in a
/// turn the main view finishes what is under way and takes no volume, until one private picture is finished.
/// After a turn the main view has the device to itself for kMainTimes as long. Outside of turns private views
/// draw while the main view has nothing to do. Pure logic: time is a parameter. Render thread only.
class PrivateShare {
 public:
  /// A turn without a picture ends: what stands in its way may be the main view itself.
  static constexpr std::int64_t kLongestTurnNs = 1'000'000'000;

  /// Whether it is the private views' turn. `due`: a private view has work; `main_busy`: something of the
  /// main view is under way.
  bool is_turn(bool due, bool main_busy, std::int64_t now_ns);

  /// A private picture is finished.
  void picture_finished(std::int64_t now_ns) { end_turn(now_ns); }

 private:
  void end_turn(std::int64_t now_ns);

  bool turn_ = false;
  std::int64_t turn_ns_ = 0;     // when the turn began
  std::int64_t private_ns_ = 0;  // when the main view had finished in it; 0: it has not
  std::int64_t main_until_ns_ = 0;
};

}  // namespace fanlight
