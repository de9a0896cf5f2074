// SPDX-License-Identifier: Apache-2.0
#include "server/access/authenticator.hpp"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

std::int64_t unix_s() {
  return std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::int64_t steady_ms() {
  return now_ns() / 1'000'000;
}

/// Without the port, which differs between connections of one client.
std::string host_of(const std::string& address) {
  return address.substr(0, address.rfind(':'));
}

}  // namespace

Result<Authenticator> Authenticator::create(const std::filesystem::path& credentials) {
  Authenticator made(credentials);
  if (!made.asks()) return made;
  made.read_ = file_version(credentials);
  auto known = Credentials::load(credentials);
  if (!known) return known.error();
  made.known_ = std::move(*known);
  return made;
}

Principal Authenticator::anyone(const std::string& address) const {
  return {.role = Role::kAdmin, .name = "loopback", .address = address};
}

Result<Principal> Authenticator::judge(const Result<Credentials::Entry>& entry, const std::string& address) {
  const std::string host = host_of(address);
  // Correct credentials are never delayed: other clients may share the address.
  if (entry) {
    // Other displays and the log show the name; a file written by hand may hold anything.
    return Principal{
        .role = entry->role, .name = printable(entry->name), .proof = entry->id, .address = address};
  }
  if (const std::int64_t wait_ms = guard_.wait_ms(host, steady_ms()); wait_ms > 0) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("the last try from this address failed too, expected the next one in {} s",
                             (wait_ms + 999) / 1000)};
  }
  guard_.failed(host, steady_ms());
  audit_->note({.name = "unknown", .address = address},
               {.what = "login", .result = "refused: " + entry.error().message});
  return Error{
      ErrorCode::kInvalidArgument,
      "this token or certificate does not open Fanlight, expected one that is known and has not expired"};
}

Result<Principal> Authenticator::by_token(std::string_view token, const std::string& address) {
  thread_owner_.check();
  return judge(known_.token(token, unix_s()), address);
}

Result<Principal> Authenticator::by_certificate(const Digest& fingerprint, const std::string& address) {
  thread_owner_.check();
  return judge(known_.certificate(fingerprint, unix_s()), address);
}

bool Authenticator::may_stay(const Principal& principal) const {
  return !asks() || known_.holds(principal.proof, principal.role, unix_s());
}

bool Authenticator::reload(std::string& trouble, bool in_any_case) {
  trouble.clear();
  if (!asks()) return false;
  const FileVersion mark = file_version(path_);
  if (mark == read_ && !in_any_case) return false;
  auto known = Credentials::load(path_);
  if (known) {
    read_ = mark;
    known_ = std::move(*known);
    trouble_.clear();
    return true;
  }
  trouble = known.error().message;
  return std::exchange(trouble_, trouble) != trouble || in_any_case;
}

}  // namespace fanlight
