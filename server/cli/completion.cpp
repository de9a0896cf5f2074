// SPDX-License-Identifier: Apache-2.0
#include "server/cli/completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "server/help/option_table.hpp"

namespace fanlight {

namespace {

bool is_path(const OptionRow& row) {
  return row.value == "FILE" || row.value == "PATH" || row.value == "PICTURE" || row.value == "FOLDER" ||
         row.value == "INPUT" || row.value == "SOURCE";
}

/// Every command with its path, those inside others, too.
void collect(const CLI::App& command, std::vector<const CLI::App*>& commands) {
  commands.push_back(&command);
  for (const CLI::App* const each : subcommands(command)) collect(*each, commands);
}

std::vector<std::string> command_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* const each : subcommands(command)) names.push_back(each->get_name());
  return names;
}

/// What an argument without a name may be; empty: a file, or any text.
std::vector<std::string> words_of(const OptionRow& row, const CLI::App& command) {
  return row.value == "COMMAND" ? command_names(program_of(command)) : row.choices;
}

/// What may follow the command: its commands, its options, and the words that its arguments may be.
std::vector<std::string> words_of(const CLI::App& command) {
  std::vector<std::string> words = command_names(command);
  for (const OptionGroup& group : option_table(command)) {
    for (const OptionRow& row : group.rows) {
      words.insert(words.end(), row.names.begin(), row.names.end());
      if (row.positional() && takes_source(command)) words.emplace_back("phantom:");
      if (!row.names.empty()) continue;
      const auto values = words_of(row, command);
      words.insert(words.end(), values.begin(), values.end());
    }
  }
  return words;
}

std::string bash_values(const CLI::App& command) {
  std::string cases;
  for (const OptionGroup& group : option_table(command)) {
    for (const OptionRow& row : group.rows) {
      if (row.names.empty() || row.flag()) continue;
      const std::string names = fmt::format("{}", fmt::join(row.names, "|"));
      if (!row.choices.empty()) {
        cases += fmt::format("        {}) words='{}' ;;\n", names, fmt::join(row.choices, " "));
      } else {
        // Readline completes files where there are no words.
        cases += fmt::format("        {}) words='' ;;\n", names);
      }
    }
  }
  return cases;
}

std::string bash_script(const CLI::App& program) {
  std::vector<const CLI::App*> commands;
  collect(program, commands);
  std::string cases;
  for (const CLI::App* const command : commands) {
    cases += fmt::format(
        "    '{}')\n      words='{}'\n      case \"$before\" in\n{}        *) ;;\n      esac\n      ;;\n",
        command_path(*command), fmt::join(words_of(*command), " "), bash_values(*command));
  }
  std::string paths;
  for (const CLI::App* const command : commands) paths += fmt::format("|{}", command_path(*command));
  return fmt::format(
      "# bash completion of fanlight\n"
      "_fanlight() {{\n"
      "  local word=\"${{COMP_WORDS[COMP_CWORD]}}\" before=\"${{COMP_WORDS[COMP_CWORD - 1]}}\"\n"
      "  local path='' words='' longer i\n"
      "  # --policy=newest is three words to bash, as '=' is in COMP_WORDBREAKS.\n"
      "  [[ \"$word\" != '=' ]] || word=''\n"
      "  [[ \"$before\" != '=' ]] || before=\"${{COMP_WORDS[COMP_CWORD - 2]}}\"\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    longer=\"${{path:+$path }}${{COMP_WORDS[i]}}\"\n"
      "    case '{}|' in *\"|$longer|\"*) path=\"$longer\" ;; esac\n"
      "  done\n"
      "  case \"$path\" in\n{}  esac\n"
      "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
      "  [[ \"${{COMPREPLY[0]:-}}\" != *: ]] || compopt -o nospace\n"
      "}}\n"
      "complete -o bashdefault -o default -F _fanlight fanlight\n",
      paths, cases);
}

/// In single quotes of a shell.
std::string single_quoted(std::string_view text) {
  std::string safe = "'";
  for (const char c : text) {
    if (c == '\'') {
      safe += "'\\''";
    } else {
      safe += c;
    }
  }
  return safe + "'";
}

std::string fish_script(const CLI::App& program) {
  std::string text = "# fish completion of fanlight\ncomplete -c fanlight -f -n __fish_use_subcommand\n";
  std::vector<const CLI::App*> commands;
  collect(program, commands);
  for (const CLI::App* const command : commands) {
    const std::string path = command_path(*command);
    const std::string here = path.empty()
                                 ? "__fish_use_subcommand"
                                 : fmt::format("__fish_seen_subcommand_from {}", command->get_name());
    for (const CLI::App* const each : subcommands(*command)) {
      text += fmt::format("complete -c fanlight -f -n {} -a {} -d {}\n", single_quoted(here),
                          each->get_name(), single_quoted(each->get_description()));
    }
    for (const OptionGroup& group : option_table(*command)) {
      for (const OptionRow& row : group.rows) {
        if (const auto words = words_of(row, *command); row.positional() && !words.empty()) {
          text += fmt::format("complete -c fanlight -f -n {} -a {}\n", single_quoted(here),
                              single_quoted(fmt::format("{}", fmt::join(words, " "))));
        }
        if (row.names.empty()) continue;
        std::string line = fmt::format("complete -c fanlight -n {}", single_quoted(here));
        for (const std::string& name : row.names)
          line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        if (!row.choices.empty())
          line += fmt::format(" -x -a {}", single_quoted(fmt::format("{}", fmt::join(row.choices, " "))));
        else if (is_path(row))
          line += " -r -F";
        else if (!row.flag())
          line += " -x";
        text += line + " -d " + single_quoted(row.text) + "\n";
      }
    }
  }
  return text;
}

/// In an argument of zsh's _arguments, where [ ] and : have a meaning.
std::string zsh_text(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') safe += '\\';
    safe += c;
  }
  return safe;
}

std::string zsh_arguments(const CLI::App& command) {
  std::string text;
  for (const OptionGroup& group : option_table(command)) {
    for (const OptionRow& row : group.rows) {
      for (const std::string& name : row.names) {
        std::string value;
        if (!row.choices.empty())
          value = fmt::format(":value:({})", fmt::join(row.choices, " "));
        else if (is_path(row))
          value = ":file:_files";
        else if (!row.flag())
          value = fmt::format(":{}: ", zsh_text(row.value));
        text += " \\\n        " + single_quoted(fmt::format("{}[{}]{}", name, zsh_text(row.text), value));
      }
      if (!row.positional()) continue;
      const auto words = words_of(row, command);
      text += words.empty()
                  ? " \\\n        '*:file:_files'"
                  : fmt::format(" \\\n        '1:{}:({})'", zsh_text(row.value), fmt::join(words, " "));
    }
  }
  return text;
}

std::string zsh_script(const CLI::App& program) {
  std::string list;
  std::string cases;
  for (const CLI::App* const each : subcommands(program)) {
    list += "    " + single_quoted(each->get_name() + ":" + zsh_text(each->get_description())) + "\n";
    std::string inside;
    for (const CLI::App* const sub : subcommands(*each)) {
      inside += fmt::format(
          "        if [[ ${{words[2]}} == {0} ]] && ((CURRENT > 2)); then\n        shift words\n        "
          "((CURRENT--))\n"
          "        _arguments{1}\n        return\n        fi\n",
          sub->get_name(), zsh_arguments(*sub));
    }
    const std::vector<std::string> names = command_names(*each);
    const std::string first =
        names.empty() ? "" : fmt::format(" \\\n        '1:command:({})'", fmt::join(names, " "));
    cases += fmt::format("      {})\n{}        _arguments{}{}\n        ;;\n", each->get_name(), inside,
                         zsh_arguments(*each), first);
  }
  return fmt::format(
      "#compdef fanlight\n# zsh completion of fanlight\n_fanlight() {{\n  local -a commands\n  "
      "commands=(\n{}  )\n"
      "  if ((CURRENT == 2)); then\n    _describe command commands\n    return\n  fi\n"
      "  local command=${{words[2]}}\n  shift words\n  ((CURRENT--))\n  case $command in\n{}  esac\n}}\n"
      "if [[ ${{funcstack[1]}} == _fanlight ]]; then _fanlight \"$@\"; else compdef _fanlight fanlight; fi\n",
      list, cases);
}

}  // namespace

Result<std::string> completion_script(const CLI::App& program, std::string_view shell) {
  if (shell == "bash") return bash_script(program);
  if (shell == "fish") return fish_script(program);
  if (shell == "zsh") return zsh_script(program);
  return Error{ErrorCode::kInvalidArgument,
               fmt::format("there is no completion for {}, expected bash, zsh or fish", shell)};
}

}  // namespace fanlight
