#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "proto/result.hpp"
#include "server/audit_log.hpp"
#include "server/credentials.hpp"
#include "server/file_mark.hpp"
#include "server/login_guard.hpp"
#include "server/role.hpp"

namespace fanlight {

/// Who may come in, as what. Failed tries are audited, and make their address wait. Server thread only.
class AccessDesk {
 public:
  /// `credentials`: a file for Credentials::load; empty: everyone is an admin, for loopback. Errors:
  /// Credentials::load's.
  static Result<AccessDesk> create(const std::filesystem::path& credentials);

  /// Where failed tries are noted; outlives the desk. Before the first.
  void audit_to(AuditLog& audit) { audit_ = &audit; }

  /// Whether a token or a certificate is needed.
  bool asks() const { return !path_.empty(); }

  /// Who needs none. Precondition: !asks().
  Visitor anyone(const std::string& address) const;

  /// Error: the sentence is for whoever tried, and does not tell what of it was wrong.
  Result<Visitor> by_token(std::string_view token, const std::string& address);
  Result<Visitor> by_certificate(const Digest& fingerprint, const std::string& address);

  /// Whether somebody who came in may stay.
  bool may_stay(const Visitor& visitor) const;

  /// Reads the file again where it was written; what cannot be read leaves what was known in force, and is
  /// tried again. True where there is something new to say, in `trouble` where it is one.
  bool reload(std::string& trouble);

 private:
  explicit AccessDesk(std::filesystem::path path) : path_(std::move(path)) {}
  Result<Visitor> judge(const Result<Credentials::Entry>& entry, const std::string& address);

  std::filesystem::path path_;
  AuditLog* audit_ = nullptr;
  Credentials known_;
  FileMark read_;
  std::string trouble_;
  LoginGuard guard_;
};

}  // namespace fanlight
