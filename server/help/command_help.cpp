// SPDX-License-Identifier: Apache-2.0
#include "server/help/command_help.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>

#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "server/help/option_table.hpp"
#include "server/help/unknown_argument.hpp"

namespace fanlight {

namespace {

constexpr std::size_t kWidth = 80;
constexpr std::size_t kTextColumn = 28;

/// The words of a text in lines that begin in a column; the first line continues where something stands
/// already.
std::string wrapped(std::string_view text, std::size_t column) {
  std::string lines;
  std::size_t used = column;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, std::min(text.find(' '), text.size()));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    if (used > column && used + 1 + word.size() > kWidth) {
      lines += "\n" + std::string(column, ' ');
      used = column;
    }
    if (used > column) {
      lines += ' ';
      ++used;
    }
    lines += word;
    used += word.size();
  }
  return lines;
}

/// "  name       text", with the text below where the name is long.
std::string row_text(const std::string& name, std::string_view text) {
  std::string line = "  " + name;
  if (line.size() + 2 > kTextColumn) {
    line += '\n';
    line.append(kTextColumn, ' ');
  } else {
    line.append(kTextColumn - line.size(), ' ');
  }
  return line + wrapped(text, kTextColumn) + "\n";
}

std::string heading_of(const OptionRow& row) {
  std::vector<std::string> names = row.names;
  if (row.positional()) names.insert(names.begin(), row.option->get_name(true, false));
  std::string heading = fmt::format("{}", fmt::join(names, ", "));
  if (!row.flag() && !row.names.empty()) heading += " " + row.value;
  return heading;
}

std::string option_text(const OptionRow& row) {
  const std::string usual = row.usual.empty() || row.flag() ? "" : fmt::format(" (default {})", row.usual);
  return row_text(heading_of(row), row.text + usual);
}

std::string examples_text(const CLI::App& command) {
  // The native display is a program of its own.
  const bool views = program_of(command).get_name() == "fanlight view";
  const auto examples = examples_of(views ? "view" : command_path(command));
  if (examples.empty()) return "";
  std::string text = "\nExamples:\n";
  for (const Example& example : examples) {
    constexpr std::size_t kExampleColumn = 50;
    const bool fits = example.command.size() <= kExampleColumn;
    text += fits ? fmt::format("  {:<{}} {}\n", example.command, kExampleColumn, example.text)
                 : fmt::format("  {}\n  {:{}} {}\n", example.command, "", kExampleColumn, example.text);
  }
  return text;
}

std::string groups_text(const CLI::App& command, bool all) {
  std::string text;
  std::size_t left_out = 0;
  for (const OptionGroup& group : option_table(command)) {
    if (is_rare(group.name) && !all) {
      left_out += group.rows.size();
      continue;
    }
    text += fmt::format("\n{}:\n", group.name);
    for (const OptionRow& row : group.rows) text += option_text(row);
  }
  if (left_out > 0) {
    text += fmt::format(
        "\n{} more options set one field of the scene each, such as --detector.threshold 30; "
        "--help-all\nlists them.\n",
        left_out);
  }
  return text;
}

class CommandFormatter : public CLI::FormatterBase {
 public:
  std::string make_help(const CLI::App* app, std::string /*name*/, CLI::AppFormatMode mode) const override {
    return command_help(*app, mode == CLI::AppFormatMode::All);
  }
};

void use_formatter(CLI::App& command, const std::shared_ptr<CommandFormatter>& formatter) {
  command.formatter(formatter);
  const auto groups = option_table(command);
  if (std::ranges::any_of(groups, [](const OptionGroup& group) { return is_rare(group.name); }))
    command.set_help_all_flag("--help-all", "Print all options, including those of the scene, and exit")
        ->group("Help");
  if (command.get_help_ptr() != nullptr)
    command.set_help_flag("-h,--help", "Print this help and exit")->group("Help");
  for (CLI::App* const sub : command.get_subcommands([](CLI::App*) { return true; }))
    use_formatter(*sub, formatter);
}

}  // namespace

std::string sentence_of(const CLI::App& command) {
  const std::string& text = command.get_description();
  return text.ends_with('.') ? text : text + ".";
}

std::string command_usage(const CLI::App& command) {
  std::string usage = program_of(command).get_name();
  if (const std::string path = command_path(command); !path.empty()) usage += " " + path;
  for (const CLI::Option* const option : command.get_options()) {
    if (!option->get_positional()) continue;
    std::string name = option->get_name(true, false);
    if (option->get_items_expected_max() > 1) name += "...";
    usage += option->get_required() ? " " + name : " [" + name + "]";
  }
  for (const OptionGroup& group : option_table(command)) {
    for (const OptionRow& row : group.rows) {
      if (!row.positional() && row.option->get_required())
        usage += fmt::format(" {} {}", row.names.front(), row.value);
    }
  }
  usage += " [OPTIONS]";
  if (!subcommands(command).empty())
    usage += command.get_require_subcommand_min() > 0 ? " COMMAND" : " [COMMAND]";
  return usage;
}

std::string command_help(const CLI::App& command, bool all) {
  std::string text = wrapped(sentence_of(command), 0) + "\n\nUsage: " + command_usage(command) + "\n";
  text += examples_text(command);
  const auto commands = subcommands(command);
  if (!commands.empty()) {
    text += "\nCommands:\n";
    for (const CLI::App* const each : commands) text += row_text(each->get_name(), each->get_description());
    const std::string path = command_path(command);
    text += fmt::format("\n`fanlight help {}{}COMMAND` prints the help for one.\n", path,
                        path.empty() ? "" : " ");
  }
  text += groups_text(command, all);
  if (takes_source(command)) {
    text += "\nThe simulated probe, phantom:NAME=VALUE,NAME=VALUE,...:\n";
    for (const PhantomOption& each : phantom_option_texts())
      text += row_text(std::string(each.name), fmt::format("{}: {}", each.text, each.expected));
  }
  if (!command.get_footer().empty()) text += "\n" + command.get_footer() + "\n";
  return text;
}

void use_command_help(CLI::App& program) {
  use_formatter(program, std::make_shared<CommandFormatter>());
}

std::string lacking_command(const CLI::App& program, const std::vector<std::string>& words) {
  const CLI::App* command = &program;
  for (const std::string& word : words) {
    if (command->get_require_subcommand_min() == 0 || word.starts_with('-')) return "";
    const CLI::App* const inner = find_subcommand(*command, word);
    if (inner == nullptr) return unknown_argument(*command, {word});
    command = inner;
  }
  if (command->get_require_subcommand_min() == 0) return "";
  std::vector<std::string> names;
  for (const CLI::App* const each : subcommands(*command)) names.push_back(each->get_name());
  return fmt::format("{} alone does nothing, expected one of its commands: {}", command_path(*command),
                     fmt::join(names, ", "));
}

}  // namespace fanlight
