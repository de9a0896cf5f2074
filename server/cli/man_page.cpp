// SPDX-License-Identifier: Apache-2.0
#include "server/cli/man_page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>

#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "proto/base/version.hpp"
#include "server/help/command_help.hpp"
#include "server/help/option_table.hpp"

namespace fanlight {

namespace {

/// As man(7) reads it: dashes that can be copied, and no line that is taken for a request.
std::string plain(std::string_view text) {
  std::string safe = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char c : text) {
    if (c == '\\') {
      safe += "\\e";
    } else if (c == '-') {
      safe += "\\-";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string bold(std::string_view text) {
  return "\\fB" + plain(text) + "\\fR";
}

std::string italic(std::string_view text) {
  return "\\fI" + plain(text) + "\\fR";
}

std::string upper(std::string_view text) {
  std::string capitals(text);
  std::ranges::transform(capitals, capitals.begin(), [](unsigned char c) { return std::toupper(c); });
  return capitals;
}

std::string page_name(const std::string& path) {
  std::string name = path.empty() ? "fanlight" : "fanlight-" + path;
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string option_text(const OptionRow& row) {
  std::vector<std::string> names;
  if (row.positional()) names.push_back(italic(row.option->get_name(true, false)));
  for (const std::string& name : row.names) names.push_back(bold(name));
  std::string heading = fmt::format("{}", fmt::join(names, ", "));
  if (!row.flag() && !row.names.empty()) heading += " " + italic(row.value);
  std::string text = fmt::format(".TP\n{}\n{}.", heading, plain(row.text));
  if (!row.usual.empty() && !row.flag()) text += fmt::format("\nThe default is {}.", plain(row.usual));
  return text + "\n";
}

std::string synopsis(const CLI::App& command, const std::string& path) {
  std::string line = bold(path.empty() ? "fanlight" : "fanlight " + path);
  for (const CLI::Option* const option : command.get_options()) {
    if (!option->get_positional()) continue;
    const std::string name = italic(option->get_name(true, false));
    line += option->get_required() ? " " + name : " [" + name + "]";
  }
  line += " [" + italic("OPTIONS") + "]";
  if (!subcommands(command).empty()) line += " " + italic("COMMAND");
  return line + "\n";
}

std::string environment(const std::string& path) {
  std::string text = ".SH ENVIRONMENT\n";
  const auto variable = [&](std::string_view name, std::string_view what) {
    text += fmt::format(".TP\n{}\n{}\n", bold(name), plain(what));
  };
  if (path == "serve") {
    variable("FANLIGHT_CONFIG", "The file of --config.");
    variable("FANLIGHT_OPTION",
             "Any option above: FANLIGHT_LISTEN for --listen, FANLIGHT_DETECTOR_THRESHOLD for "
             "--detector.threshold; 1 or 0 for an option without a value. The command line takes precedence, "
             "then the "
             "environment, then the file.");
  }
  if (path == "watch" || path == "view") variable("FANLIGHT_TOKEN", "Access token, if no file is given.");
  variable("XDG_CACHE_HOME", "Compiled shaders are cached in its folder fanlight.");
  if (path == "serve") variable("XDG_STATE_HOME", "Saved presets are stored in its folder fanlight.");
  return text;
}

}  // namespace

std::string man_page(const CLI::App& command) {
  const std::string path = command_path(command);
  std::string text = fmt::format(
      ".TH {} 1 \"\" \"Fanlight {}\" \"Fanlight\"\n.SH NAME\n{} \\- {}\n", plain(upper(page_name(path))),
      plain(version()), plain(page_name(path)),
      plain(path.empty() ? "render 4D ultrasound and stream it to displays" : command.get_description()));
  text += ".SH SYNOPSIS\n" + synopsis(command, path);
  text += ".SH DESCRIPTION\n" + plain(sentence_of(command)) + "\n";
  if (const auto commands = subcommands(command); !commands.empty()) {
    text += ".SH COMMANDS\n";
    for (const CLI::App* const each : commands)
      text += fmt::format(".TP\n{}\n{}.\n", bold(each->get_name()), plain(each->get_description()));
  }
  if (const auto examples = examples_of(path); !examples.empty()) {
    text += ".SH EXAMPLES\n";
    for (const Example& example : examples)
      text += fmt::format(".TP\n{}\n{}.\n", bold(example.command), plain(example.text));
  }
  for (const OptionGroup& group : option_table(command)) {
    text += fmt::format(".SH {}\n", plain(upper(group.name)));
    for (const OptionRow& row : group.rows) text += option_text(row);
  }
  if (takes_source(command)) {
    text += ".SH SIMULATED PROBE\n" + plain("phantom:NAME=VALUE,NAME=VALUE,... with these names:") + "\n";
    for (const PhantomOption& each : phantom_option_texts())
      text += fmt::format(".TP\n{}\n{}: {}.\n", bold(each.name), plain(each.text), plain(each.expected));
  }
  if (!command.get_footer().empty()) text += ".SH NOTES\n" + plain(command.get_footer()) + "\n";
  text += environment(path);
  text += ".SH EXIT STATUS\n";
  for (const ExitCode& code : exit_codes())
    text += fmt::format(".TP\n{}\n{}.\n", code.code, plain(code.text));
  text += ".SH SEE ALSO\n";
  std::vector<std::string> others;
  if (command.get_parent() != nullptr) others.push_back(bold(page_name(command_path(*command.get_parent()))));
  for (const CLI::App* const each : subcommands(command))
    others.push_back(bold(page_name(command_path(*each))));
  for (std::string& other : others) other += "(1)";
  return text + fmt::format("{}\n", fmt::join(others, ",\n"));
}

}  // namespace fanlight
