// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

namespace fanlight {

/// Watches whether the scene in force is shown. A change that no picture shows after kPatienceNs is reported;
/// one that the renderer has refused is withdrawn after kWithdrawalNs. A cast that only takes long is not:
/// the picture comes. Time is a parameter. Pure logic, server thread only.
class SceneWatch {
 public:
  static constexpr std::int64_t kPatienceNs = 2'000'000'000;
  static constexpr std::int64_t kWithdrawalNs = 10'000'000'000;

  /// What holds at a call of update().
  struct Situation {
    std::uint64_t in_force = 0;         ///< revision of the scene in force
    std::uint64_t shown = 0;            ///< revision that the newest picture shows
    std::uint64_t refused = 0;          ///< revision that the renderer cannot draw; 0: none
    bool are_pictures_expected = true;  ///< false: there are none, for another reason
  };
  enum class Event : std::uint8_t {
    kNone,
    kNotShown,   ///< a change has become overdue
    kWithdrawn,  ///< it is to be withdrawn now
  };

  /// Call it several times a second.
  Event update(const Situation& now, std::int64_t now_ns);

  /// A change is overdue.
  bool is_overdue() const { return overdue_; }

 private:
  struct Change {
    std::uint64_t revision = 0;
    std::int64_t since_ns = 0;
  };
  void follow(const Situation& now, std::int64_t now_ns);

  std::deque<Change> waiting_;  // changes that no picture shows yet, the oldest first
  std::uint64_t newest_ = 0;    // revision that was seen last
  std::int64_t last_ns_ = 0;
  bool overdue_ = false;
};

}  // namespace fanlight
