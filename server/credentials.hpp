#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/result.hpp"
#include "server/digest.hpp"
#include "server/role.hpp"

namespace fanlight {

/// Who may come in, from a TOML file that `fanlight token` writes:
///
///   [[token]]
///   id = "3f9a0c21"
///   name = "theatre 3"
///   role = "operator"
///   sha256 = "64 hexadecimal digits"
///   expires = "2027-01-31"           # the first day (UTC) on which it is of no use; none: never
///
///   [[certificate]]                  # of a client, besides being signed by --client-ca
///   name = "console 2"
///   role = "admin"
///   sha256 = "its fingerprint"
///
/// Only the hash of a token is kept: of 256 random bits, so that no slow or salted hash is needed to keep it
/// from being guessed (NIST SP 800-63B, 5.1.2.2: look-up secrets of 112 bits or more).
class Credentials {
 public:
  struct Entry {
    std::string id;  ///< of a token; a certificate's fingerprint
    std::string name;
    Role role = Role::kViewer;
    Digest hash{};
    std::optional<std::int64_t> expires_s;  ///< Unix time
  };

  /// Errors: kNotFound, or kBadInput with the place and what was expected. A file that others than its owner
  /// may write is refused.
  static Result<Credentials> load(const std::filesystem::path& path);

  /// Whose token it is, in a time that does not depend on how much of it is right. Errors, kInvalidArgument:
  /// it is no token, not a known one, or expired; the sentence is for the log, not for who asked.
  Result<Entry> token(std::string_view text, std::int64_t now_s) const;

  /// Whose certificate has this fingerprint.
  Result<Entry> certificate(const Digest& fingerprint, std::int64_t now_s) const;

  /// Whether who came in with this proof may stay: the entry is there, with the role that it had, and has not
  /// expired.
  bool holds(const std::string& proof, Role role, std::int64_t now_s) const;

  const std::vector<Entry>& tokens() const { return tokens_; }

 private:
  std::vector<Entry> tokens_;
  std::vector<Entry> certificates_;
};

/// A new token: its text, which is shown once and kept nowhere, and its entry.
struct NewToken {
  std::string text;  ///< "fl_" + id + "_" + 64 hexadecimal digits
  Credentials::Entry entry;
};
NewToken make_token(std::string name, Role role, std::optional<std::int64_t> expires_s);

/// Writes the entry behind what is in the file, which is made where there is none, for its owner alone.
Result<void> append_token(const std::filesystem::path& path, const Credentials::Entry& entry);

/// Takes the entry with this id out of the file; what else is in it stays as it is. kNotFound without one.
Result<void> remove_token(const std::filesystem::path& path, std::string_view id);

/// "2027-01-31" as Unix time.
std::optional<std::int64_t> parse_day(std::string_view text);
std::string day_text(std::int64_t unix_s);

}  // namespace fanlight
