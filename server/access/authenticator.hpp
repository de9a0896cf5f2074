// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "server/access/audit_log.hpp"
#include "server/access/credentials.hpp"
#include "server/access/file_version.hpp"
#include "server/access/login_backoff.hpp"
#include "server/access/role.hpp"

namespace fanlight {

/// Authenticates clients by token or certificate, and gives them their role. Failed attempts are audited, and
/// delay further attempts from the same address. Server thread only.
class Authenticator {
 public:
  /// `credentials`: a file for Credentials::load. If it is empty, every client is an admin; for loopback
  /// only. Errors: those of Credentials::load.
  static Result<Authenticator> create(const std::filesystem::path& credentials);

  /// Sets the log for failed attempts, before the first one. It must outlive this object.
  void audit_to(AuditLog& audit) { audit_ = &audit; }

  /// Whether clients need a token or a certificate.
  bool asks() const { return !path_.empty(); }

  /// The principal of a client that needs none. Precondition: !asks().
  Principal anyone(const std::string& address) const;

  /// Errors: the sentence is for the client, and does not say which part was wrong.
  Result<Principal> by_token(std::string_view token, const std::string& address);
  Result<Principal> by_certificate(const Digest& fingerprint, const std::string& address);

  /// Whether a client that was authenticated before is still allowed to stay.
  bool may_stay(const Principal& principal) const;

  /// Reads the file again if it changed, or `in_any_case`. If that fails, the old credentials stay in force
  /// and the next call tries again. Returns true if the result is new, or was asked for in any case:
  /// `trouble` is empty for success, else it is the error.
  bool reload(std::string& trouble, bool in_any_case = false);

 private:
  explicit Authenticator(std::filesystem::path path) : path_(std::move(path)) {}
  Result<Principal> judge(const Result<Credentials::Entry>& entry, const std::string& address);

  std::filesystem::path path_;
  AuditLog* audit_ = nullptr;
  Credentials known_;
  FileVersion read_;
  std::string trouble_;
  LoginBackoff guard_;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
