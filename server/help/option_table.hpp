// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace fanlight {

/// An option of a command, as people read it. Help texts, man pages, completions and configurations are made
/// of these rows, so that they cannot say different things.
struct OptionRow {
  const CLI::Option* option = nullptr;
  std::vector<std::string> names;    ///< "-V", "--version"; empty for an argument without a name
  std::string value;                 ///< what follows the name: "FILE"; empty for a flag
  std::string text;                  ///< what it does, with what it needs and excludes
  std::string usual;                 ///< its default as text; empty: none
  std::vector<std::string> choices;  ///< the values that it takes; empty: see `value`

  bool positional() const { return option->get_positional(); }
  bool flag() const { return value.empty(); }
  /// Its longest name without dashes, such as "listen"; empty for an argument without a name.
  std::string key() const;
};

struct OptionGroup {
  std::string name;
  std::vector<OptionRow> rows;
};

/// The options of a command in the order in which they were added, by groups.
std::vector<OptionGroup> option_table(const CLI::App& command);

/// The commands that a command has, in their order.
std::vector<const CLI::App*> subcommands(const CLI::App& command);

/// The command of this name that a command has; null: it has none.
const CLI::App* find_subcommand(const CLI::App& command, std::string_view name);

/// A group of rare options: --help names it in one line, --help-all and the man page have all of it.
bool is_rare(std::string_view group);

/// A command line to try, and what it does.
struct Example {
  std::string_view command;
  std::string_view text;
};

/// Examples of a command: "serve", "token add"; "" for the program.
std::vector<Example> examples_of(std::string_view command);

/// "token add" of that subcommand; "" of the program.
std::string command_path(const CLI::App& command);

/// The program that a command belongs to.
const CLI::App& program_of(const CLI::App& command);

/// Whether the simulated probe may be named: its options are printed then.
bool takes_source(const CLI::App& command);

/// What the exit codes of all commands mean.
struct ExitCode {
  int code;
  std::string_view text;
};
std::vector<ExitCode> exit_codes();

}  // namespace fanlight
