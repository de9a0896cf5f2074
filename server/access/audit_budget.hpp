// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "server/access/audit_entry.hpp"

namespace fanlight {

/// Bounds how many lines of the audit log a client can cause. Each kind of event has a budget for each
/// principal, and for acts also for each session: no client can use up what another one's act needs, and
/// refusals never use up what acts need. Events beyond a budget are folded: counted, for one line a second.
/// Pure logic: no clock. One thread.
class AuditBudget {
 public:
  /// Events that got no line of their own.
  struct Folded {
    Principal who;
    AuditEvent event;  ///< the newest of them; its result is "folded"
    std::uint64_t count = 0;
    nlohmann::json newest;  ///< details of the newest one; null: it had none
  };

  static constexpr int kLinesASecond = 20;
  /// More than this many principals and sessions within a second share one budget for each kind of event.
  static constexpr std::size_t kMostBudgets = 256;
  /// Scripts read pictures again and again, and that says little: one line within this time.
  static constexpr int kSecondsOfAPictureRead = 60;

  /// Whether the event gets a line. If not, it is counted.
  bool take(const Principal& who, const AuditEvent& event, const nlohmann::json& details);

  /// Call this once a second. Returns the acts that were folded since the last call.
  std::vector<Folded> second_passed();

  /// Call this at the end. As second_passed(), but for all budgets.
  std::vector<Folded> end();

  /// Refusals that got no line since the last call.
  std::uint64_t take_refusals_unlisted() { return std::exchange(refusals_unlisted_, 0); }

 private:
  struct Budget {
    int lines_left = 0;
    int seconds_left = 0;
    Folded folded;
  };
  std::vector<Folded> take_folded(bool all);

  std::map<std::string, Budget> budgets_;
  std::uint64_t refusals_unlisted_ = 0;
};

}  // namespace fanlight
