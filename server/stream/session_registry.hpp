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

#include "proto/base/thread_owner.hpp"
#include "server/state/notice.hpp"
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

  /// The state has changed.
  virtual void notify(Notice notice) = 0;

  /// The server has ended its private view.
  virtual void view_ended(const std::string& reason) = 0;

  /// The server has withdrawn the last change of the main view's scene. Notice::kScene follows.
  virtual void scene_withdrawn(const std::string& reason) = 0;

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
  /// `act`: called when a session has opened, as reported by opened().
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

  /// Notifies every open session except one; 0: no exception. After kScene also, with kView, those whose
  /// private views follow the main view's scene.
  void notify(Notice notice, std::uint64_t except_session = 0);

  /// The server has withdrawn the last change of the scene: notifies every open session, once with the
  /// reason.
  void scene_withdrawn(const std::string& reason);

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
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
