// SPDX-License-Identifier: Apache-2.0
#include "server/access/control_lease.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fanlight {

namespace {

// More than may sit around one patient.
constexpr std::size_t kMostAsking = 64;

Error refusal(std::string sentence) {
  return {ErrorCode::kInvalidArgument, std::move(sentence)};
}

}  // namespace

Error ControlLease::held() const {
  return refusal(fmt::format("{} (session {}) is in control, expected a request for control first",
                             state_.holder.name, state_.holder.session));
}

void ControlLease::give(const Party& who, std::int64_t now_ms) {
  state_.holder = who;
  heard_ms_ = now_ms;
  std::erase_if(state_.asking, [&](const Party& one) { return one.session == who.session; });
}

void ControlLease::hand_on(std::int64_t now_ms) {
  state_.holder = {};
  if (!state_.asking.empty()) give(Party(state_.asking.front()), now_ms);
}

Result<void> ControlLease::may_change(std::uint64_t session) const {
  if (state_.holder.session != 0 && !holds(session)) return held();
  return {};
}

Result<void> ControlLease::use(const Party& who, std::int64_t now_ms) {
  thread_owner_.check();
  if (auto may = may_change(who.session); !may) return may;
  give(who, now_ms);
  return {};
}

Result<bool> ControlLease::ask(const Party& who, std::int64_t now_ms) {
  thread_owner_.check();
  if (state_.holder.session == 0 || holds(who.session)) {
    give(who, now_ms);
    return true;
  }
  const bool asked = std::ranges::find(state_.asking, who.session, &Party::session) != state_.asking.end();
  if (!asked && state_.asking.size() >= kMostAsking) {
    return refusal(
        fmt::format("{} sessions have requested control already, expected a later request", kMostAsking));
  }
  if (!asked) state_.asking.push_back(who);
  return false;
}

Result<bool> ControlLease::release(std::uint64_t session, std::int64_t now_ms) {
  thread_owner_.check();
  if (holds(session)) {
    hand_on(now_ms);
    return false;
  }
  if (std::erase_if(state_.asking, [&](const Party& one) { return one.session == session; }) == 0) {
    return refusal("this session neither has the control nor asks for it, expected one of them");
  }
  return false;
}

Result<bool> ControlLease::grant(std::uint64_t from, std::uint64_t to, std::int64_t now_ms) {
  thread_owner_.check();
  if (!holds(from)) return refusal("this session is not in control, expected it to be before it hands it on");
  const auto asking = std::ranges::find(state_.asking, to, &Party::session);
  if (asking == state_.asking.end()) {
    return refusal(fmt::format("session {} has not requested control, expected one that has", to));
  }
  give(Party(*asking), now_ms);
  return false;
}

void ControlLease::take_over(const Party& who, std::int64_t now_ms) {
  thread_owner_.check();
  give(who, now_ms);
}

Result<bool> ControlLease::keep(std::uint64_t session, std::int64_t now_ms) {
  thread_owner_.check();
  if (!holds(session)) return refusal("this session is not in control, expected it to be to keep it");
  heard_ms_ = now_ms;
  return true;
}

bool ControlLease::renamed(const Party& who) {
  thread_owner_.check();
  bool known = holds(who.session);
  if (known) state_.holder.name = who.name;
  for (Party& asking : state_.asking) {
    if (asking.session != who.session) continue;
    asking.name = who.name;
    known = true;
  }
  return known;
}

bool ControlLease::left(std::uint64_t session, std::int64_t now_ms) {
  thread_owner_.check();
  const bool asked =
      std::erase_if(state_.asking, [&](const Party& one) { return one.session == session; }) > 0;
  if (!holds(session)) return asked;
  hand_on(now_ms);
  return true;
}

bool ControlLease::expire(std::int64_t now_ms) {
  thread_owner_.check();
  if (state_.holder.session == 0 || now_ms - heard_ms_ < lapse_ms_) return false;
  hand_on(now_ms);
  return true;
}

}  // namespace fanlight
