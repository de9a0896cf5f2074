// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/store_outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>

namespace fanlight {

StoreOutcome outcome_of_status(std::uint16_t status) {
  using State = StoreOutcome::State;
  const auto is_one_of = [status](std::initializer_list<unsigned> statuses) {
    return std::ranges::find(statuses, unsigned{status}) != statuses.end();
  };
  constexpr unsigned kWarnings = 0xB000;  // to 0xBFFF
  constexpr unsigned kNoRoom = 0xA700;    // to 0xA7FF
  constexpr unsigned kDuplicate = 0x0111;
  if (status == 0) return StoreOutcome::of_peer(State::kStored, "");
  // Mostly this one, after an answer that was lost; but a file from elsewhere may have the same identifier.
  if (status == kDuplicate)
    return StoreOutcome::of_peer(State::kRefused, "it has an object with this identifier already");
  if ((status & 0xF000U) == kWarnings || is_one_of({0x0001, 0x0107, 0x0116}))
    return StoreOutcome::of_peer(State::kStored,
                                 fmt::format("stored with a warning, status {:#06x}", status));
  if ((status & 0xFF00U) == kNoRoom)
    return StoreOutcome::of_peer(State::kNotSent, fmt::format("it has no room, status {:#06x}", status));
  // Processing failure, not authorized, resource limitation.
  if (is_one_of({0x0110, 0x0124, 0x0213}))
    return StoreOutcome::of_peer(State::kNotSent, fmt::format("it cannot store now, status {:#06x}", status));
  return StoreOutcome::of_peer(State::kRefused, fmt::format("it refuses the object, status {:#06x}", status));
}

}  // namespace fanlight
