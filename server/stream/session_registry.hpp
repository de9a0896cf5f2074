// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/state/view_admission.hpp"

namespace fanlight {

/// A session, as the server and the other sessions notify it. Server thread only.
class RegisteredSession {
 public:
  virtual ~RegisteredSession() = default;

  virtual std::uint64_t id() const = 0;

  /// Whether its client is authenticated. Only open sessions receive the notifications below, except
  /// second_passed(), end() and abandon().
  virtual bool is_open() const = 0;

  /// The scene of the main view has changed.
  virtual void scene_changed() = 0;

  /// Another session holds control, or none.
  virtual void control_changed() = 0;

  /// The state of the probe has changed.
  virtual void probe_changed() = 0;

  /// The main view's picture is live, or is not live any more, or for another reason.
  virtual void liveness_changed() = 0;

  /// The state of the recorder has changed.
  virtual void recording_changed() = 0;

  /// The state of the player of a recording has changed.
  virtual void replay_changed() = 0;

  /// Another of the last volumes is shown, or new ones are again.
  virtual void cine_changed() = 0;

  /// A preset was saved or removed.
  virtual void presets_changed() = 0;

  /// The pictures are sent beyond the room, or are not any more.
  virtual void relay_changed() = 0;

  /// The render thread has looked for the surface, as this session wished.
  virtual void survey_answered(const v1::SurveyReply& reply) = 0;

  /// The scene of its private view has changed.
  virtual void view_changed() = 0;

  /// The server has ended its private view.
  virtual void view_ended(const std::string& reason) = 0;

  /// Called once a second. May remove the session.
  virtual void second_passed() = 0;

  /// The server ends: sends a close frame with the code 1001 and this reason, at most 123 bytes.
  virtual void end(const std::string& reason) = 0;

  /// The server ends. Removes the session.
  virtual void abandon() = 0;
};

/// Owns the connected sessions and notifies them. Notifications may be sent by the sessions themselves, but
/// must not add or remove one, except those that say so. Server thread only.
class SessionRegistry {
 public:
  /// `views` must outlive the registry.
  explicit SessionRegistry(ViewAdmission& views) : views_(views) {}

  /// The number of a new session, from 1 on.
  std::uint64_t next_id() { return ++last_id_; }

  /// Keeps the session alive until remove().
  void add(const std::shared_ptr<RegisteredSession>& session) { sessions_[session->id()] = session; }
  /// `act`: called when a session has opened, and told so by opened().
  void when_opened(std::function<void()> act) { opened_ = std::move(act); }
  void opened() const {
    if (opened_) opened_();
  }
  std::size_t open_count() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(sessions_, [](const auto& entry) { return entry.second->is_open(); }));
  }
  void remove(std::uint64_t id) { sessions_.erase(id); }

  /// All sessions, in the order of their numbers, also those that are not open.
  std::vector<std::shared_ptr<RegisteredSession>> all() const;

  /// Notifies every open session except one (0: no exception), and those whose private views follow the main
  /// view's scene.
  void scene_changed(std::uint64_t except_session);
  void control_changed();
  void probe_changed();
  void liveness_changed();
  void recording_changed();
  void replay_changed();
  void cine_changed();
  void relay_changed();
  void presets_changed();

  /// Passes the answer on to the session, where it is still there.
  void survey_answered(std::uint64_t session, const v1::SurveyReply& reply);

  /// The server has ended the private view of this session.
  void view_ended(std::uint64_t session, const std::string& reason);

 private:
  template <typename Notify>
  void for_each_open(Notify notify) {
    for (const auto& [id, session] : sessions_) {
      if (session->is_open()) notify(*session);
    }
  }

  ViewAdmission& views_;
  std::function<void()> opened_;
  std::map<std::uint64_t, std::shared_ptr<RegisteredSession>> sessions_;
  std::uint64_t last_id_ = 0;
};

}  // namespace fanlight
