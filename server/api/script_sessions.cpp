// SPDX-License-Identifier: Apache-2.0
#include "server/api/script_sessions.hpp"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>

namespace fanlight {

namespace {

constexpr std::int64_t kNsPerMs = 1'000'000;

/// 128 random bits; empty: the system has none.
std::string random_key() {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) return "";
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

bool same_key(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

bool same_client(const Principal& a, const Principal& b) {
  return a.name == b.name && a.proof == b.proof;
}

}  // namespace

Result<ScriptSession*> ScriptSessions::open(const Principal& principal, const std::string& name,
                                            std::int64_t now_ns) {
  thread_owner_.check();
  if (!is_session_name(name)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the name has letters that do not print or over {} bytes, expected another",
                             kLongestNameBytes)};
  }
  if (sessions_.size() >= kMost) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{} scripts have or want control already, expected a later request", kMost)};
  }
  std::string key = random_key();
  if (key.empty()) return Error{ErrorCode::kUnavailable, "the system has no random numbers"};
  return &sessions_.emplace_back(dependencies_.audit,
                                 SessionIdentity{.id = dependencies_.sessions.next_id(),
                                                 .address = principal.address,
                                                 .principal = principal,
                                                 .name = name.empty() ? principal.name : name},
                                 std::move(key), now_ns);
}

ScriptSession* ScriptSessions::find(std::string_view key, const Principal& principal, std::int64_t now_ns) {
  thread_owner_.check();
  for (ScriptSession& each : sessions_) {
    if (!same_key(each.key_, key) || !same_client(*each.identity_.principal, principal)) continue;
    each.identity_.principal = principal;  // of a role that may have changed
    each.heard_ns_ = now_ns;
    if (dependencies_.control.holds(each.id()))
      (void)dependencies_.control.keep(each.id(), now_ns / kNsPerMs);
    return &each;
  }
  return nullptr;
}

ScriptSessions::Sessions::iterator ScriptSessions::close(Sessions::iterator session) {
  session->audit_.flush_changes();
  dependencies_.commands.forget(session->id());
  return sessions_.erase(session);
}

void ScriptSessions::close(ScriptSession& session) {
  thread_owner_.check();
  const auto found = std::ranges::find(sessions_, session.id(), &ScriptSession::id);
  if (found != sessions_.end()) close(found);
}

void ScriptSessions::close_all() {
  while (!sessions_.empty()) close(sessions_.begin());
}

void ScriptSessions::second_passed(std::int64_t now_ns) {
  thread_owner_.check();
  const std::int64_t lapse_ns = dependencies_.control.lapse_ms() * kNsPerMs;
  for (auto each = sessions_.begin(); each != sessions_.end();) {
    each->audit_.flush_changes();
    const bool stays =
        now_ns - each->heard_ns_ < lapse_ns && dependencies_.access.may_stay(*each->identity_.principal);
    each = stays ? std::next(each) : close(each);
  }
}

}  // namespace fanlight
