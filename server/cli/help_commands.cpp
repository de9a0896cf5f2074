// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <vector>

#include "proto/base/version.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/completion.hpp"
#include "server/cli/man_page.hpp"
#include "server/help/command_help.hpp"
#include "server/help/option_table.hpp"
#include "server/help/unknown_argument.hpp"

namespace fanlight {

namespace {

/// The command that words such as "token add" name.
Result<const CLI::App*> find_command(const CLI::App& program, const std::vector<std::string>& words) {
  const CLI::App* command = &program;
  for (const std::string& word : words) {
    const CLI::App* const inner = find_subcommand(*command, word);
    if (inner == nullptr) return Error{ErrorCode::kInvalidArgument, unknown_argument(*command, {word})};
    command = inner;
  }
  return command;
}

/// A command about another one, whose text it prints.
template <typename TextOf>
Command add_text_command(CLI::App& program, const char* name, const char* help, TextOf text_of) {
  CLI::App* const command = program.add_subcommand(name, help);
  const auto words = std::make_shared<std::vector<std::string>>();
  command->add_option("COMMAND", *words, "Command to print the page of; default: the program")
      ->type_name("COMMAND");
  return [&program, words, text_of]() -> Result<void> {
    const auto found = find_command(program, *words);
    if (!found) throw CLI::ConfigError(found.error().message);
    fmt::print("{}", text_of(**found));
    return {};
  };
}

}  // namespace

Command add_help_command(CLI::App& program) {
  return add_text_command(program, "help", "Print help for a command", [](const CLI::App& command) {
    // The native display is a program of its own and may not be installed.
    if (command_path(command) == "view") (void)run_native_display({"--help"});
    return command_help(command, false);
  });
}

Command add_man_command(CLI::App& program) {
  return add_text_command(program, "man", "Print a manual page, for man(1)", man_page);
}

Command add_version_command(CLI::App& program) {
  program.add_subcommand("version", "Print the version");
  return []() -> Result<void> {
    fmt::print("{}\n", version());
    return {};
  };
}

Command add_completion_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("completion", "Print the completion script for a shell");
  const auto shell = std::make_shared<std::string>();
  command->add_option("SHELL", *shell, "bash, zsh or fish")->required()->type_name("bash|zsh|fish");
  return [&program, shell]() -> Result<void> {
    const auto script = completion_script(program, *shell);
    if (!script) throw CLI::ConfigError(script.error().message);
    fmt::print("{}", *script);
    return {};
  };
}

}  // namespace fanlight
