// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/base/result.hpp"
#include "server/access/digest.hpp"
#include "server/access/role.hpp"

namespace fanlight {

/// The tokens and client certificates that a server accepts, from a TOML file that `fanlight token` writes:
///
///   [[token]]
///   id = "3f9a0c21"
///   name = "theatre 3"
///   role = "operator"
///   sha256 = "64 hexadecimal digits"
///   expires = "2027-01-31"           # the first day (UTC) on which it is invalid; absent: never
///
///   [[certificate]]                  # of a client; it must also be signed by --client-ca
///   name = "console 2"
///   role = "admin"
///   sha256 = "its fingerprint"
///
/// The file holds only the hash of a token. A token has 256 random bits, so that no slow or salted hash is
/// needed against guessing (NIST SP 800-63B, 5.1.2.2: look-up secrets of 112 bits or more).
class Credentials {
 public:
  struct Entry {
    std::string id;  ///< of a token; for a certificate, its fingerprint
    std::string name;
    Role role = Role::kViewer;
    Digest hash{};
    std::optional<std::int64_t> expires_s;  ///< Unix time
  };

  /// Errors: kNotFound; kBadInput with the line and what was expected, also for a file that other users than
  /// its owner may write.
  static Result<Credentials> load(const std::filesystem::path& path);

  /// Finds the entry of a token, in a time that does not depend on how many of its characters are right.
  /// Errors, kInvalidArgument: no token, unknown, or expired. The sentence is for the log, not for the
  /// client.
  Result<Entry> token(std::string_view text, std::int64_t now_s) const;

  /// Finds the entry of the certificate with this fingerprint.
  Result<Entry> certificate(const Digest& fingerprint, std::int64_t now_s) const;

  /// Whether a client that was authenticated with this proof may stay: its entry exists, has the same role,
  /// and has not expired.
  bool holds(const std::string& proof, Role role, std::int64_t now_s) const;

  const std::vector<Entry>& tokens() const { return tokens_; }

 private:
  std::vector<Entry> tokens_;
  std::vector<Entry> certificates_;
};

/// A new token: its text, which is shown once and stored nowhere, and its entry.
struct NewToken {
  std::string text;  ///< "fl_" + id + "_" + 64 hexadecimal digits
  Credentials::Entry entry;
};
NewToken make_token(std::string name, Role role, std::optional<std::int64_t> expires_s);

/// Appends the entry to the file. Creates the file with access for its owner only if it does not exist. This
/// and remove_token() replace the file whole, one call at a time among all processes. Where one fails, the
/// file is as it was.
Result<void> append_token(const std::filesystem::path& path, const Credentials::Entry& entry);

/// Removes the [[token]] table with this id and the empty line behind it from the file. All other bytes stay,
/// comments included. Errors: kNotFound; kBadInput if the file is no TOML or the table cannot be removed
/// alone.
Result<void> remove_token(const std::filesystem::path& path, std::string_view id);

/// "2027-01-31" as Unix time.
std::optional<std::int64_t> parse_day(std::string_view text);
std::string day_text(std::int64_t unix_s);

}  // namespace fanlight
