// SPDX-License-Identifier: Apache-2.0
#include "server/help/usage_sentence.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include <regex>
#include <string_view>

#include "server/help/command_help.hpp"
#include "server/help/option_table.hpp"
#include "server/help/unknown_argument.hpp"

namespace fanlight {

namespace {

/// "a, b or c" of "a,b,c".
std::string one_of(const std::string& list) {
  std::string words = std::regex_replace(list, std::regex(","), ", ");
  if (const std::size_t last = words.rfind(", "); last != std::string::npos) words.replace(last, 2, " or ");
  return words;
}

/// CLI11 writes the bound 1e6 as 1000000.000000. The user's own value, which stands before, is kept.
std::string without_empty_decimals(const std::string& sentence) {
  const std::size_t bounds = sentence.rfind(", expected ");
  if (bounds == std::string::npos) return sentence;
  return sentence.substr(0, bounds) +
         std::regex_replace(sentence.substr(bounds), std::regex("\\b(\\d+)\\.0+\\b"), "$1");
}

}  // namespace

std::string usage_sentence(const std::string& of_cli11) {
  // The sentences of CLI11 2.3 and 2.4: Error.hpp and Validators.hpp.
  struct Form {
    const char* pattern;
    const char* sentence;
  };
  static constexpr Form kForms[] = {
      {"^(\\S+): Value (.*) not in range (\\S+) to (\\S+)$", "$1 is $2, expected $3 to $4"},
      {"^(\\S+): Value (.*) not in range \\[(\\S+) - (\\S+)\\]$", "$1 is $2, expected $3 to $4"},
      {"^Could not convert: (\\S+) = (.*)$", "$1 is $2, expected a number"},
      {"^(\\S+): At Most 1 required but received .*$", "$1 is given more than once, expected it once"},
      {"^(\\S+): 1 required (\\S+) missing$", "$1 needs a value, expected $1 $2"},
      {"^(\\S+) requires (\\S+)$", "$1 needs $2, expected both"},
      {"^(\\S+) excludes (\\S+)$", "$1 and $2 exclude one another, expected one of them"},
  };
  std::smatch parts;
  if (std::regex_match(of_cli11, parts, std::regex("^(\\S+): (.*) not in \\{(.*)\\}$")))
    return fmt::format("{} is {}, expected {}", parts.str(1), parts.str(2), one_of(parts.str(3)));
  for (const Form& form : kForms) {
    if (const std::regex pattern(form.pattern); std::regex_match(of_cli11, pattern))
      return without_empty_decimals(std::regex_replace(of_cli11, pattern, form.sentence));
  }
  return of_cli11;
}

UsageError usage_error(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App* command = &program;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  const std::string path = command_path(*command);
  const std::string name = path.empty() ? program.get_name() : program.get_name() + " " + path;
  const auto unknown = command->remaining();
  const int code = error.get_exit_code();
  const bool names_unknown = code == static_cast<int>(CLI::ExitCodes::ExtrasError) ||
                             code == static_cast<int>(CLI::ExitCodes::RequiredError);
  if (names_unknown && !unknown.empty()) return {name, unknown_argument(*command, unknown)};
  if (code == static_cast<int>(CLI::ExitCodes::ConfigError)) return {name, error.what()};
  constexpr std::string_view kRequired = " is required";
  const bool lacks = code == static_cast<int>(CLI::ExitCodes::RequiredError);
  if (std::string missing = error.what(); lacks && missing.ends_with(kRequired)) {
    missing.erase(missing.size() - kRequired.size());
    return {name, fmt::format("{} is missing, expected `{}`; see `{} --help`", missing,
                              command_usage(*command), name)};
  }
  return {name, fmt::format("{}; see `{} --help`", usage_sentence(error.what()), name)};
}

}  // namespace fanlight
