// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "server/access/audit_log.hpp"
#include "server/access/credentials.hpp"
#include "server/cli/commands.hpp"

namespace fanlight {

namespace {

struct TokenOptions {
  std::string file;
  std::string name;
  std::string role = "viewer";
  std::string expires;
  std::string id;
};

Result<void> add_token(const TokenOptions& options) {
  const auto role = find_role(options.role);
  if (!role) return Error{ErrorCode::kInvalidArgument, "--role: expected viewer, operator or admin"};
  std::optional<std::int64_t> expires_s;
  if (!options.expires.empty()) {
    expires_s = parse_day(options.expires);
    if (!expires_s) return Error{ErrorCode::kInvalidArgument, "--expires: expected a day such as 2027-01-31"};
  }
  const NewToken made = make_token(options.name, *role, expires_s);
  if (auto written = append_token(options.file, made.entry); !written) return written;
  // Scripts read the token from stdout. It is stored nowhere.
  fmt::print("{}\n", made.text);
  fmt::print(stderr, "token {} for {} ({}), shown this once; {} has its hash\n", made.entry.id, options.name,
             options.role, options.file);
  return {};
}

Result<void> list_tokens(const TokenOptions& options) {
  const auto known = Credentials::load(options.file);
  if (!known) return known.error();
  fmt::print("{:<10} {:<10} {:<12} {}\n", "id", "role", "expires", "name");
  for (const Credentials::Entry& entry : known->tokens()) {
    fmt::print("{:<10} {:<10} {:<12} {}\n", entry.id, role_name(entry.role),
               entry.expires_s ? day_text(*entry.expires_s) : "never", entry.name);
  }
  return {};
}

Result<void> verify(const std::string& file) {
  const auto summary = verify_audit_log(file);
  if (!summary) return summary.error();
  fmt::print("{} lines hold together; the newest has the hash {}\n", summary->lines,
             summary->lines > 0 ? summary->newest_hash : "-");
  return {};
}

}  // namespace

Command add_token_command(CLI::App& program) {
  CLI::App* const command =
      program.add_subcommand("token", "Makes and takes back what opens a server to displays");
  command->require_subcommand(1);
  const auto options = std::make_shared<TokenOptions>();
  const auto part = [&](const char* name, const char* help) {
    CLI::App* const sub = command->add_subcommand(name, help);
    sub->add_option("--tokens", options->file, "TOML file of a server's --tokens")
        ->required()
        ->type_name("FILE");
    return sub;
  };
  CLI::App* const add = part("add", "Makes a token, prints it, and writes its hash to the file");
  add->add_option("--name", options->name, "Whose it is: a place or a device, no patient")
      ->required()
      ->type_name("TEXT");
  add->add_option("--role", options->role, "viewer, operator or admin")
      ->capture_default_str()
      ->type_name("ROLE");
  add->add_option("--expires", options->expires, "The first day (UTC) on which it is of no use")
      ->type_name("YYYY-MM-DD");
  CLI::App* const list = part("list", "Shows whose tokens there are");
  CLI::App* const revoke = part("revoke", "Takes a token back; running servers see it within a second");
  revoke->add_option("id", options->id, "Its id, as in the list")->required()->type_name("ID");
  return [options, add, list] {
    if (add->parsed()) return add_token(*options);
    return list->parsed() ? list_tokens(*options) : remove_token(options->file, options->id);
  };
}

Command add_audit_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("audit", "Checks that an audit log is as it was written");
  const auto file = std::make_shared<std::string>();
  command->add_option("file", *file, "A server's --audit-log")->required()->type_name("FILE");
  return [file] { return verify(*file); };
}

}  // namespace fanlight
