// SPDX-License-Identifier: Apache-2.0
#include "server/stream/session_registry.hpp"

#include <algorithm>

namespace fanlight {

std::vector<std::shared_ptr<RegisteredSession>> SessionRegistry::all() const {
  std::vector<std::shared_ptr<RegisteredSession>> sessions;
  sessions.reserve(sessions_.size());
  for (const auto& [id, session] : sessions_) sessions.push_back(session);
  return sessions;
}

void SessionRegistry::notify(Notice notice, std::uint64_t except_session) {
  thread_owner_.check();
  for_each_open([&](RegisteredSession& session) {
    if (session.id() != except_session) session.notify(notice);
  });
  if (notice != Notice::kScene) return;
  const auto changed = views_.main_changed();
  for_each_open([&](RegisteredSession& session) {
    if (std::ranges::find(changed, session.id()) != changed.end()) session.notify(Notice::kView);
  });
}

void SessionRegistry::scene_withdrawn(const std::string& reason) {
  thread_owner_.check();
  for_each_open([&](RegisteredSession& session) { session.scene_withdrawn(reason); });
  notify(Notice::kScene);
}

void SessionRegistry::view_ended(std::uint64_t session, const std::string& reason) {
  thread_owner_.check();
  const auto found = sessions_.find(session);
  if (found != sessions_.end() && found->second->is_open()) found->second->view_ended(reason);
}

}  // namespace fanlight
