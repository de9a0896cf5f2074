// SPDX-License-Identifier: Apache-2.0
#include "server/access/audit_budget.hpp"

#include <fmt/format.h>

#include <string_view>

namespace fanlight {

namespace {

bool is_picture_read(const AuditEvent& event) {
  return std::string_view(event.what) == "picture_read";
}

/// Whose budget an event uses. Sessions come and go at will, so their begin and end have one for all sessions
/// of a principal.
std::string budget_of(const Principal& who, const AuditEvent& event) {
  const bool refused = is_refusal(event);
  const bool by_session = !refused && !std::string_view(event.what).starts_with("session_");
  return fmt::format("{} {} {} {} {}", refused ? "refused" : "done", event.what,
                     by_session ? event.session : 0, who.proof, who.name);
}

std::string shared_budget_of(const AuditEvent& event) {
  return fmt::format("{} {}", is_refusal(event) ? "refused" : "done", event.what);
}

}  // namespace

bool AuditBudget::take(const Principal& who, const AuditEvent& event, const nlohmann::json& details) {
  std::string key = budget_of(who, event);
  if (budgets_.size() >= kMostBudgets && !budgets_.contains(key)) key = shared_budget_of(event);
  const bool rare = is_picture_read(event);
  Budget& budget = budgets_
                       .try_emplace(std::move(key), Budget{.lines_left = rare ? 1 : kLinesASecond,
                                                           .seconds_left = rare ? kSecondsOfAPictureRead : 1,
                                                           .folded = {}})
                       .first->second;
  if (budget.lines_left > 0) {
    --budget.lines_left;
    return true;
  }
  if (is_refusal(event)) {
    ++refusals_unlisted_;
    return false;
  }
  ++budget.folded.count;
  budget.folded.who = who;
  budget.folded.event = {.what = event.what, .session = event.session, .result = "folded"};
  budget.folded.newest = details;
  return false;
}

std::vector<AuditBudget::Folded> AuditBudget::second_passed() {
  return take_folded(false);
}

std::vector<AuditBudget::Folded> AuditBudget::end() {
  return take_folded(true);
}

std::vector<AuditBudget::Folded> AuditBudget::take_folded(bool all) {
  std::vector<Folded> folded;
  for (auto entry = budgets_.begin(); entry != budgets_.end();) {
    Budget& budget = entry->second;
    if (--budget.seconds_left > 0 && !all) {
      ++entry;
      continue;
    }
    if (budget.folded.count > 0) folded.push_back(std::move(budget.folded));
    entry = budgets_.erase(entry);
  }
  return folded;
}

}  // namespace fanlight
