// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "proto/base/printable.hpp"
#include "server/access/audit_chain.hpp"
#include "server/access/credentials.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/json_text.hpp"

namespace fanlight {

namespace {

struct TokenOptions {
  std::string file;
  std::string name;
  std::string role = "viewer";
  std::string expires;
  std::string id;
  bool json = false;
};

Result<std::optional<std::int64_t>> expiry_of(const TokenOptions& options) {
  if (options.expires.empty()) return std::optional<std::int64_t>();
  const auto expires_s = parse_day(options.expires);
  if (!expires_s) return Error{ErrorCode::kInvalidArgument, "--expires: expected a day such as 2027-01-31"};
  const std::int64_t now_s =
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
          .count();
  if (*expires_s > now_s) return expires_s;
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("--expires {}: a token that has expired is of no use, expected a day after {}",
                           options.expires, day_text(now_s))};
}

/// Two tokens of a name are allowed, such as of two displays in a room; they should not be made without
/// knowing.
void warn_of_namesakes(const TokenOptions& options) {
  const auto known = Credentials::load(options.file);
  if (!known) return;  // append_token() says why, or makes the file
  for (const Credentials::Entry& entry : known->tokens()) {
    if (entry.name == options.name)
      fmt::print(stderr, "a token {} with this name exists already and remains valid\n", printable(entry.id));
  }
}

Result<void> add_token(const TokenOptions& options) {
  const auto role = find_role(options.role);
  if (!role) return Error{ErrorCode::kInvalidArgument, "--role: expected viewer, operator or admin"};
  if (!is_printable(options.name)) {
    return Error{ErrorCode::kInvalidArgument,
                 "--name: it has characters that do not print, expected the name of a place or a device"};
  }
  const auto expires_s = expiry_of(options);
  if (!expires_s) return expires_s.error();
  warn_of_namesakes(options);
  const NewToken made = make_token(options.name, *role, *expires_s);
  if (auto written = append_token(options.file, made.entry); !written) return written;
  // Scripts read the token from stdout. It is stored nowhere, so one that was not printed must not stay.
  if (std::fputs((made.text + "\n").c_str(), stdout) < 0 || std::fflush(stdout) != 0) {
    auto removed = remove_token(options.file, made.entry.id);
    if (!removed) return removed;
    return Error{ErrorCode::kUnavailable,
                 "the token could not be printed and was removed from the file, "
                 "expected a standard output with room"};
  }
  fmt::print(stderr, "token {} for {} ({}), shown this once; {} has its hash\n", made.entry.id, options.name,
             options.role, options.file);
  return {};
}

Result<void> list_tokens(const TokenOptions& options) {
  const auto known = Credentials::load(options.file);
  if (!known) return known.error();
  if (options.json) {
    auto rows = nlohmann::ordered_json::array();
    for (const Credentials::Entry& entry : known->tokens()) {
      nlohmann::ordered_json row = {{"id", printable(entry.id)}, {"role", role_name(entry.role)}};
      row["expires"] = entry.expires_s ? nlohmann::ordered_json(day_text(*entry.expires_s)) : nullptr;
      row["name"] = printable(entry.name);
      rows.push_back(row);
    }
    fmt::print("{}\n", json_text(rows, 1));
    return {};
  }
  fmt::print("{:<10} {:<10} {:<12} {}\n", "id", "role", "expires", "name");
  for (const Credentials::Entry& entry : known->tokens()) {
    fmt::print("{:<10} {:<10} {:<12} {}\n", printable(entry.id), role_name(entry.role),
               entry.expires_s ? day_text(*entry.expires_s) : "never", printable(entry.name));
  }
  return {};
}

Result<void> verify(const std::vector<std::filesystem::path>& files, bool json) {
  const auto summary = verify_audit_logs(files);
  if (!summary) {
    if (json)
      fmt::print("{}\n",
                 json_text(nlohmann::ordered_json{{"holds", false}, {"why", summary.error().message}}, 1));
    return summary.error();
  }
  if (json) {
    const nlohmann::ordered_json report = {{"holds", true},
                                           {"lines", summary->lines},
                                           {"newest_hash", summary->newest_hash},
                                           {"first_line", summary->first_line},
                                           {"first_follows", summary->first_follows},
                                           {"lines_lost", summary->lost}};
    fmt::print("{}\n", json_text(report, 1));
    return {};
  }
  if (summary->lines == 0) {
    fmt::print("the log is empty: no server has written it, or its lines were removed\n");
    return {};
  }
  fmt::print("{} lines hold together; the newest has the hash {}\n", summary->lines, summary->newest_hash);
  if (summary->first_line > 1) {
    fmt::print("the first is line {} and follows the hash {} of a file before it\n", summary->first_line,
               summary->first_follows);
  }
  if (summary->lost > 0) {
    fmt::print("{} lines were lost while the log was written; entries of \"audit\" say where\n",
               summary->lost);
  }
  return {};
}

}  // namespace

Command add_token_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("token", "Manage access tokens");
  command->require_subcommand(1);
  const auto options = std::make_shared<TokenOptions>();
  const auto part = [&](const char* name, const char* help) {
    CLI::App* const sub = command->add_subcommand(name, help);
    sub->add_option("--tokens", options->file, "Token file, as given to the server with --tokens")
        ->required()
        ->type_name("FILE");
    return sub;
  };
  CLI::App* const add = part("add", "Create a token, print it, and write its hash to the file");
  add->add_option("--name", options->name, "Name of the place or device; not of a patient")
      ->required()
      ->type_name("TEXT");
  add->add_option("--role", options->role, "Role: viewer, operator or admin")
      ->capture_default_str()
      ->type_name("viewer|operator|admin");
  add->add_option("--expires", options->expires, "First day (UTC) on which the token is no longer valid")
      ->type_name("YYYY-MM-DD");
  CLI::App* const list = part("list", "List the tokens");
  list->add_flag("--json", options->json, "Print the list as JSON");
  CLI::App* const revoke = part("revoke", "Revoke a token; running servers notice within a second");
  revoke->add_option("ID", options->id, "Id of the token, as printed by list")->required()->type_name("ID");
  return [options, add, list] {
    if (add->parsed()) return add_token(*options);
    return list->parsed() ? list_tokens(*options) : remove_token(options->file, options->id);
  };
}

Command add_audit_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("audit", "Verify that an audit log was not changed");
  const auto files = std::make_shared<std::vector<std::filesystem::path>>();
  command
      ->add_option(
          "FILE", *files,
          "Audit log, as given to the server with --audit-log; all files if it was rotated, in any order")
      ->required()
      ->type_name("FILE");
  const auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print the report as JSON");
  return [files, json] { return verify(*files, *json); };
}

}  // namespace fanlight
