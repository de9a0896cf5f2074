#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/result.hpp"
#include "server/role.hpp"

namespace fanlight {

/// Who is in control of the scene and the probe: nobody, or one session. Whoever is an operator has it with
/// the first change, keeps it while something is heard of it, and hands it on. Knows sessions by number and
/// name, and time by what it is told. Server thread only.
class ControlDesk {
 public:
  struct Party {
    std::uint64_t session = 0;
    std::string name;
  };
  struct State {
    Party holder;               ///< session 0: nobody
    std::vector<Party> asking;  ///< in the order in which they asked
  };

  explicit ControlDesk(std::int64_t lapse_ms = 60'000) : lapse_ms_(lapse_ms) {}

  const State& state() const { return state_; }
  std::int64_t lapse_ms() const { return lapse_ms_; }
  bool holds(std::uint64_t session) const { return session != 0 && state_.holder.session == session; }

  /// A change is about to be made: takes the control where it is free. Error, kInvalidArgument: a viewer, or
  /// another session is in control.
  Result<void> use(const Party& who, Role role, std::int64_t now_ms);

  /// Whether it is free or this session's, for one whose changes do not take it.
  Result<void> may_change(const Party& who, Role role) const;

  // What a session may wish; false where it is not in control by it. Errors: kInvalidArgument.
  Result<bool> ask(const Party& who, Role role, std::int64_t now_ms);
  Result<bool> release(std::uint64_t session, std::int64_t now_ms);
  Result<bool> grant(std::uint64_t from, std::uint64_t to, std::int64_t now_ms);
  Result<bool> take_over(const Party& who, Role role, std::int64_t now_ms);
  Result<bool> keep(std::uint64_t session, std::int64_t now_ms);

  /// The session goes by another name; true where the state is another one now.
  bool renamed(const Party& who);

  /// The session is gone; true where the state is another one now.
  bool left(std::uint64_t session, std::int64_t now_ms);

  /// Time passes; true where the control lapsed.
  bool lapse(std::int64_t now_ms);

 private:
  void hand_on(std::int64_t now_ms);
  void give(const Party& who, std::int64_t now_ms);
  Error held() const;

  std::int64_t lapse_ms_;
  State state_;
  std::int64_t heard_ms_ = 0;  // of the holder
};

}  // namespace fanlight
