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

void SessionRegistry::scene_changed(std::uint64_t except_session) {
  for_each_open([&](RegisteredSession& session) {
    if (session.id() != except_session) session.scene_changed();
  });
  const auto changed = views_.main_changed();
  for_each_open([&](RegisteredSession& session) {
    if (std::ranges::find(changed, session.id()) != changed.end()) session.view_changed();
  });
}

void SessionRegistry::control_changed() {
  for_each_open([](RegisteredSession& session) { session.control_changed(); });
}

void SessionRegistry::probe_changed() {
  for_each_open([](RegisteredSession& session) { session.probe_changed(); });
}

void SessionRegistry::liveness_changed() {
  for_each_open([](RegisteredSession& session) { session.liveness_changed(); });
}

void SessionRegistry::recording_changed() {
  for_each_open([](RegisteredSession& session) { session.recording_changed(); });
}

void SessionRegistry::replay_changed() {
  for_each_open([](RegisteredSession& session) { session.replay_changed(); });
}

void SessionRegistry::cine_changed() {
  for_each_open([](RegisteredSession& session) { session.cine_changed(); });
}

void SessionRegistry::relay_changed() {
  for_each_open([](RegisteredSession& session) { session.relay_changed(); });
}

void SessionRegistry::presets_changed() {
  for_each_open([](RegisteredSession& session) { session.presets_changed(); });
}

void SessionRegistry::survey_answered(std::uint64_t session, const v1::SurveyReply& reply) {
  const auto found = sessions_.find(session);
  if (found != sessions_.end() && found->second->is_open()) found->second->survey_answered(reply);
}

void SessionRegistry::view_ended(std::uint64_t session, const std::string& reason) {
  const auto found = sessions_.find(session);
  if (found != sessions_.end() && found->second->is_open()) found->second->view_ended(reason);
}

}  // namespace fanlight
