// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"

namespace fanlight {

/// The lease for control of the scene and the probe. At most one session holds it. A session acquires it with
/// its first change if it is free, loses it after `lapse_ms` without activity, and may grant it to another
/// session. Roles are checked before: see command_rules.hpp. Pure logic: sessions are numbers and names, and
/// time is a parameter. Server thread only.
class ControlLease {
 public:
  struct Party {
    std::uint64_t session = 0;
    std::string name;
  };
  struct State {
    Party holder;               ///< session 0: no holder
    std::vector<Party> asking;  ///< in the order in which they asked
  };

  explicit ControlLease(std::int64_t lapse_ms = 60'000) : lapse_ms_(lapse_ms) {}

  const State& state() const { return state_; }
  std::int64_t lapse_ms() const { return lapse_ms_; }
  void set_lapse_ms(std::int64_t lapse_ms) { lapse_ms_ = lapse_ms; }
  bool holds(std::uint64_t session) const { return session != 0 && state_.holder.session == session; }

  /// Whether a change is allowed: control is free, or this session holds it. Session 0 never holds it. Error,
  /// kInvalidArgument: another session holds it.
  Result<void> may_change(std::uint64_t session) const;

  /// Acquires control if it is free. Errors: as of may_change().
  Result<void> use(const Party& who, std::int64_t now_ms);

  // Requests of a session. Return whether the session holds control afterwards. Errors: kInvalidArgument.
  Result<bool> ask(const Party& who, std::int64_t now_ms);
  Result<bool> release(std::uint64_t session, std::int64_t now_ms);
  Result<bool> grant(std::uint64_t from, std::uint64_t to, std::int64_t now_ms);
  void take_over(const Party& who, std::int64_t now_ms);
  Result<bool> keep(std::uint64_t session, std::int64_t now_ms);

  /// The session changed its name. Returns whether the state changed.
  bool renamed(const Party& who);

  /// The session ended. Returns whether the state changed.
  bool left(std::uint64_t session, std::int64_t now_ms);

  /// Call this regularly. Returns true if control lapsed now.
  bool expire(std::int64_t now_ms);

 private:
  void hand_on(std::int64_t now_ms);
  void give(const Party& who, std::int64_t now_ms);
  Error held() const;

  std::int64_t lapse_ms_;
  State state_;
  std::int64_t heard_ms_ = 0;  // last activity of the holder
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
