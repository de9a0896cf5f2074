// SPDX-License-Identifier: Apache-2.0
#include "server/command/session_audit.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "server/state/scene_json.hpp"

namespace fanlight {

void SessionAudit::note(const char* what, const std::string& result) {
  log_.note(*session_.principal, {.what = what, .session = session_.id, .result = result});
}

void SessionAudit::note(const char* what, const std::string& result, const nlohmann::json& details) {
  log_.note(*session_.principal, {.what = what, .session = session_.id, .result = result}, details);
}

void SessionAudit::add_change(const v1::Scene& change) {
  if (session_.id == 0) return note("scene_change", "done", change_json(change));
  changes_.MergeFrom(change);
  ++change_count_;
}

void SessionAudit::flush_changes() {
  const std::uint64_t count = std::exchange(change_count_, 0);
  if (count == 0) return;
  log_.note(*session_.principal, {.what = "scene_change", .session = session_.id, .result = "done"},
            {{"changes", count}, {"to", change_json(changes_)}});
  changes_.Clear();
}

}  // namespace fanlight
