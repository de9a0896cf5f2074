// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <utility>

namespace fanlight {

/// What became of a file that was to be stored.
struct StoreOutcome {
  enum class State : std::uint8_t {
    kStored,    ///< the peer has it
    kRefused,   ///< the peer will not take this object; sending it again does not help
    kNotSent,   ///< it could not be read, the peer had no room, or the connection broke; it may be sent again
    kNotTried,  ///< the connection had broken before, or `stop` was set
  };
  static StoreOutcome of_peer(State state, std::string sentence) {
    return {state, false, std::move(sentence)};
  }
  static StoreOutcome local(State state, std::string sentence) { return {state, true, std::move(sentence)}; }

  State state = State::kNotTried;
  bool is_local = false;  ///< found on this machine: the peer was not asked
  /// One sentence: why not, or the peer's warning about what it has stored. Empty where there is none.
  std::string sentence;
};

/// After so many failures of the peer's in a row, other objects would most likely fare alike.
constexpr int kMostFailuresInARow = 3;

/// What a status in the answer to a C-STORE means (PS3.4, table B.2-1, and PS3.7, annex C).
StoreOutcome outcome_of_status(std::uint16_t status);

}  // namespace fanlight
