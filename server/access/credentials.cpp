// SPDX-License-Identifier: Apache-2.0
#include "server/access/credentials.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <sstream>
#include <system_error>
#include <toml.hpp>

#include "proto/base/file_replacement.hpp"
#include "proto/base/toml_excess.hpp"
#include "proto/base/toml_place.hpp"
#include "server/access/folder_lock.hpp"

namespace fanlight {

namespace {

constexpr std::string_view kPrefix = "fl_";
constexpr std::size_t kIdLetters = 8;
constexpr std::size_t kTokenLetters = kPrefix.size() + kIdLetters + 1 + 64;

Error bad(const std::filesystem::path& path, const std::string& what) {
  return {ErrorCode::kBadInput, fmt::format("{}: {}", path.string(), what)};
}

Result<std::string> text_of(const std::filesystem::path& path) {
  const auto unreadable = [&path] {
    return bad(path, fmt::format("it cannot be read ({})", std::generic_category().message(errno)));
  };
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return unreadable();
  std::string text;
  std::array<char, 4096> part{};
  ssize_t bytes = 0;
  while ((bytes = read(file, part.data(), part.size())) > 0) text.append(part.data(), bytes);
  if (bytes < 0) {
    const Error failed = unreadable();
    close(file);
    return failed;
  }
  close(file);
  return text;
}

Result<toml::value> parse_toml(const std::filesystem::path& path, const std::string& text) {
  if (const std::string excess = toml_excess(text); !excess.empty()) return bad(path, excess);
  try {
    std::istringstream stream(text);
    return toml::parse(stream, path.string());
  } catch (const std::exception& wrong) {
    const std::string sentence = wrong.what();
    return bad(path, fmt::format("it is no TOML file ({})", sentence.substr(0, sentence.find('\n'))));
  }
}

/// Lines of a file, from 1 on, both included.
struct Lines {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// Offset of the first byte of a line; the size of the text if it has fewer lines.
std::size_t line_offset(std::string_view text, std::size_t line) {
  std::size_t offset = 0;
  for (; line > 1 && offset < text.size(); --line) {
    const std::size_t end = text.find('\n', offset);
    offset = end == std::string_view::npos ? text.size() : end + 1;
  }
  return offset;
}

/// Of a table only its heading. `Location` is toml::source_location, which is another class in toml11 4.
template <typename Location>
Lines lines_at(const Location& location, std::string_view text) {
  if constexpr (requires { location.first_line_number(); }) {
    return {.first = location.first_line_number(), .last = location.last_line_number()};
  } else {
    // An array or a string can go over several lines.
    const std::size_t begin = line_offset(text, location.line()) + location.column() - 1;
    const auto bytes = text.substr(std::min(begin, text.size()), location.region());
    const auto more = static_cast<std::size_t>(std::ranges::count(bytes, '\n'));
    return {.first = location.line(), .last = location.line() + more};
  }
}

/// From the heading of a table, or the begin of another value, to its last line.
Lines lines_of(const toml::value& value, std::string_view text) {
  Lines lines = lines_at(value.location(), text);
  if (!value.is_table()) return lines;
  for (const auto& [key, member] : value.as_table()) {
    lines.last = std::max(lines.last, lines_of(member, text).last);
  }
  return lines;
}

Result<Credentials::Entry> entry_of(const toml::value& table, const std::filesystem::path& path, bool token) {
  const std::string where = fmt::format("line {}", toml_line(table.location()));
  const auto text = [&](const char* key) { return toml::find_or<std::string>(table, key, ""); };
  Credentials::Entry entry{.id = text("id"), .name = text("name")};
  const auto role = find_role(text("role"));
  const auto hash = digest_from_hex(text("sha256"));
  if (!role) return bad(path, where + ": expected a role of viewer, operator or admin");
  if (!hash) return bad(path, where + ": expected sha256 to be 64 hexadecimal digits");
  if (entry.name.empty()) return bad(path, where + ": expected a name");
  if (token && entry.id.size() != kIdLetters) {
    return bad(path, fmt::format("{}: expected an id of {} letters", where, kIdLetters));
  }
  entry.role = *role;
  entry.hash = *hash;
  if (!token) entry.id = hex(*hash);
  if (const std::string expires = text("expires"); !expires.empty()) {
    entry.expires_s = parse_day(expires);
    if (!entry.expires_s) return bad(path, where + ": expected expires to be a day such as \"2027-01-31\"");
  }
  return entry;
}

Result<std::vector<Credentials::Entry>> entries_of(const toml::value& file, const char* kind,
                                                   const std::filesystem::path& path) {
  std::vector<Credentials::Entry> entries;
  if (!file.contains(kind)) return entries;
  const toml::value& list = file.at(kind);
  if (!list.is_array()) return bad(path, fmt::format("expected [[{}]], not [{}]", kind, kind));
  for (const toml::value& table : list.as_array()) {
    auto entry = entry_of(table, path, std::string_view(kind) == "token");
    if (!entry) return entry.error();
    entries.push_back(std::move(*entry));
  }
  return entries;
}

bool is_token(const toml::value& table, std::string_view id) {
  return table.is_table() && toml::find_or<std::string>(table, "id", "") == id;
}

/// From the heading to the last key of the first token with this id.
std::optional<Lines> lines_of_token(const toml::value& file, std::string_view text, std::string_view id) {
  if (!file.contains("token") || !file.at("token").is_array()) return std::nullopt;
  const auto& tokens = file.at("token").as_array();
  const auto found =
      std::ranges::find_if(tokens, [id](const toml::value& table) { return is_token(table, id); });
  if (found == tokens.end()) return std::nullopt;
  return lines_of(*found, text);
}

/// The text without these lines, and without the empty line that append_token() writes behind them.
std::string without_lines(const std::string& text, const Lines& lines) {
  const std::size_t begin = line_offset(text, lines.first);
  std::size_t end = line_offset(text, lines.last + 1);
  if (text.compare(end, 1, "\n") == 0) ++end;
  return text.substr(0, begin) + text.substr(end);
}

toml::value without_token(toml::value file, std::string_view id) {
  auto& tokens = file.at("token").as_array();
  tokens.erase(std::ranges::find_if(tokens, [id](const toml::value& table) { return is_token(table, id); }));
  if (tokens.empty()) file.as_table().erase("token");
  return file;
}

/// toml11 4 keeps comments, and compares them.
toml::value without_comments(toml::value value) {
  value.comments().clear();
  if (value.is_array()) {
    for (toml::value& each : value.as_array()) each = without_comments(each);
  }
  if (value.is_table()) {
    for (auto& [key, each] : value.as_table()) each = without_comments(each);
  }
  return value;
}

/// Replaces the file whole, because a server may read it at any moment. One that the server may not read any
/// more would close all sessions, so the owner must stay.
Result<void> replace_tokens(const std::filesystem::path& path, const std::string& text) {
  return replace_file(path, text, {.mode = S_IRUSR | S_IWUSR, .must_keep_owner = true});
}

bool expired(const Credentials::Entry& entry, std::int64_t now_s) {
  return entry.expires_s && now_s >= *entry.expires_s;
}

}  // namespace

Result<Credentials> Credentials::load(const std::filesystem::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) {
    return Error{
        ErrorCode::kNotFound,
        fmt::format("{}: there is no such file, expected tokens made by `fanlight token`", path.string())};
  }
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return bad(path, "others than its owner may write it, expected chmod go-w");
  }
  const auto text = text_of(path);
  if (!text) return text.error();
  const auto file = parse_toml(path, *text);
  if (!file) return file.error();
  Credentials made;
  for (const auto& [kind, entries] :
       {std::pair("token", &made.tokens_), std::pair("certificate", &made.certificates_)}) {
    auto read = entries_of(*file, kind, path);
    if (!read) return read.error();
    *entries = std::move(*read);
  }
  return made;
}

Result<Credentials::Entry> Credentials::token(std::string_view text, std::int64_t now_s) const {
  const Error unknown{ErrorCode::kInvalidArgument, "the token is not a known one"};
  const bool shaped =
      text.size() == kTokenLetters && text.starts_with(kPrefix) && text[kPrefix.size() + kIdLetters] == '_';
  if (!shaped) return Error{ErrorCode::kInvalidArgument, "it has not the form of a token"};
  const std::string_view id = text.substr(kPrefix.size(), kIdLetters);
  // The id is no secret; what is compared at leisure is the hash of all of it.
  const Digest given = sha256(text);
  const auto entry = std::ranges::find(tokens_, id, &Entry::id);
  if (entry == tokens_.end()) return unknown;
  if (!same_digest(entry->hash, given)) return unknown;
  if (expired(*entry, now_s)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the token {} has expired on {}", entry->id, day_text(*entry->expires_s))};
  }
  return *entry;
}

Result<Credentials::Entry> Credentials::certificate(const Digest& fingerprint, std::int64_t now_s) const {
  const auto entry = std::ranges::find_if(
      certificates_, [&](const Entry& one) { return same_digest(one.hash, fingerprint); });
  if (entry == certificates_.end()) {
    return Error{ErrorCode::kInvalidArgument, "the certificate is not among those that may come in"};
  }
  if (expired(*entry, now_s)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the certificate's entry has expired on {}", day_text(*entry->expires_s))};
  }
  return *entry;
}

bool Credentials::holds(const std::string& proof, Role role, std::int64_t now_s) const {
  for (const auto* entries : {&tokens_, &certificates_}) {
    for (const Entry& entry : *entries) {
      if (entry.id == proof) return entry.role == role && !expired(entry, now_s);
    }
  }
  return false;
}

NewToken make_token(std::string name, Role role, std::optional<std::int64_t> expires_s) {
  std::array<std::uint8_t, kIdLetters / 2> id;
  std::array<std::uint8_t, 32> secret;
  fill_random(id);
  fill_random(secret);
  NewToken made{.text = fmt::format("{}{}_{}", kPrefix, hex(id), hex(secret)),
                .entry = {.id = hex(id), .name = std::move(name), .role = role, .expires_s = expires_s}};
  made.entry.hash = sha256(made.text);
  return made;
}

Result<void> append_token(const std::filesystem::path& path, const Credentials::Entry& entry) {
  const std::string expires =
      entry.expires_s ? fmt::format("expires = \"{}\"\n", day_text(*entry.expires_s)) : "";
  const std::string text =
      fmt::format("[[token]]\nid = \"{}\"\nname = {}\nrole = \"{}\"\nsha256 = \"{}\"\n{}\n", entry.id,
                  toml::format(toml::value(entry.name)), role_name(entry.role), hex(entry.hash), expires);
  const auto lock = FolderLock::take(path);
  if (!lock) return lock.error();
  std::string whole;
  if (std::error_code absent; std::filesystem::is_regular_file(path, absent)) {
    auto before = text_of(path);
    if (!before) return before.error();
    whole = std::move(*before);
    if (!whole.empty() && whole.back() != '\n') whole += '\n';
  }
  return replace_tokens(path, whole + text);
}

Result<void> remove_token(const std::filesystem::path& path, std::string_view id) {
  const auto lock = FolderLock::take(path);
  if (!lock) return lock.error();
  const auto before = text_of(path);
  if (!before) return before.error();
  std::string text = *before;
  for (;;) {  // a file written by hand may have the same id twice
    auto file = parse_toml(path, text);
    if (!file) return file.error();
    const auto lines = lines_of_token(*file, text, id);
    if (!lines) break;
    std::string kept = without_lines(text, *lines);
    const auto after = parse_toml(path, kept);
    if (!after || without_comments(*after) != without_comments(without_token(std::move(*file), id))) {
      return bad(
          path, fmt::format("line {}: the token {} cannot be removed alone, expected a [[token]] table whose "
                            "lines stand together",
                            lines->first, id));
    }
    text = std::move(kept);
  }
  if (text == *before) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("{} has no token {}, expected an id that `fanlight token list` shows",
                             path.string(), id)};
  }
  return replace_tokens(path, text);
}

std::optional<std::int64_t> parse_day(std::string_view text) {
  int year = 0;
  unsigned month = 0;
  unsigned day = 0;
  const auto number = [](std::string_view part, auto& value) {
    const auto [end, failure] = std::from_chars(part.data(), part.data() + part.size(), value);
    return failure == std::errc{} && end == part.data() + part.size();
  };
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return std::nullopt;
  if (!number(text.substr(0, 4), year) || !number(text.substr(5, 2), month) ||
      !number(text.substr(8, 2), day)) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_seconds(std::chrono::sys_days(date)).time_since_epoch().count();
}

std::string day_text(std::int64_t unix_s) {
  const std::chrono::sys_seconds time{std::chrono::seconds(unix_s)};
  const std::chrono::year_month_day date{std::chrono::floor<std::chrono::days>(time)};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

}  // namespace fanlight
