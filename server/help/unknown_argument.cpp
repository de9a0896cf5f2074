// SPDX-License-Identifier: Apache-2.0
#include "server/help/unknown_argument.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "acquisition/phantom/phantom_options.hpp"
#include "proto/base/nearest_name.hpp"
#include "proto/base/printable.hpp"
#include "server/help/option_table.hpp"

namespace fanlight {

namespace {

/// What common programs call some of the options here.
struct OtherName {
  std::string_view name;
  std::string_view own;
};
constexpr OtherName kOtherNames[] = {{"--output", "--out"},     {"-o", "--out"},
                                     {"--port", "--listen"},    {"-p", "--listen"},
                                     {"--bind", "--listen"},    {"--host", "--listen"},
                                     {"--address", "--listen"}, {"--input", "--source"},
                                     {"-i", "--source"},        {"--width", "--size"},
                                     {"--height", "--size"},    {"--resolution", "--size"},
                                     {"--device", "--gpu"},     {"--loop", "--ending loop"}};

std::string first_word(std::string_view text) {
  return std::string(text.substr(0, text.find(' ')));
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const OptionGroup& group : option_table(command))
    for (const OptionRow& row : group.rows) names.insert(names.end(), row.names.begin(), row.names.end());
  return names;
}

bool is_probe_name(std::string_view name) {
  const auto options = phantom_option_texts();
  return std::ranges::find(options, name, &PhantomOption::name) != options.end();
}

bool is_probe_option(std::string_view word) {
  const std::size_t equals = word.find('=');
  return equals != std::string_view::npos && is_probe_name(word.substr(0, equals));
}

std::string meant_option(const CLI::App& command, const std::string& name) {
  std::vector<std::string> known = option_names(command);
  std::vector<OtherName> others;
  for (const OtherName& other : kOtherNames)
    if (std::ranges::find(known, first_word(other.own)) != known.end()) others.push_back(other);
  // Nearly another program's name, --prot: only where it begins alike, for most names are near to some other.
  for (const OtherName& other : others)
    if (other.name.substr(0, 3) == name.substr(0, 3)) known.emplace_back(other.name);
  const auto named = [&](const std::string& wanted) {
    return std::ranges::find(others, wanted, &OtherName::name);
  };
  if (const auto other = named(name); other != others.end()) return std::string(other->own);
  const std::string bare = name.starts_with("--") ? name.substr(2) : "";
  const auto ends_in_it = [&](const std::string& each) { return each.ends_with("." + bare); };
  if (takes_source(command) && is_probe_name(bare) && std::ranges::none_of(known, ends_in_it))
    return fmt::format("phantom:{}=...", bare);
  const std::string meant = nearest_name(name, known);
  const auto other = named(meant);
  return other == others.end() ? meant : std::string(other->own);
}

/// The simulated probe with the words that are its options, given after a space. Empty: another source, or
/// other words.
std::string meant_probe(const CLI::App& command, const std::vector<std::string>& words) {
  for (const CLI::Option* const option : command.get_options()) {
    if (!option->get_positional() || option->count() != 1) continue;
    std::string probe = option->results().front();
    if (!probe.starts_with("phantom:") || !is_probe_option(words.front())) return "";
    for (const std::string& word : words) {
      if (!is_probe_option(word)) break;
      if (!probe.ends_with(':') && !probe.ends_with(',')) probe += ',';
      probe += word;
    }
    return printable(probe);
  }
  return "";
}

/// Not with a file that is there: it may be the second half of a name with a space, or another input.
std::string meant_output(const CLI::App& command, const std::string& word) {
  const CLI::Option* const out = command.get_option_no_throw("--out");
  const bool lacks_output = command.parsed() && out != nullptr && out->count() == 0;
  const bool is_name = !word.empty() && word.find_first_of("= ") == std::string::npos;
  std::error_code unknown;
  return lacks_output && is_name && !std::filesystem::exists(word, unknown)
             ? fmt::format("--out {}", printable(word))
             : "";
}

std::string meant_command(const CLI::App& command, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* const each : subcommands(command)) names.push_back(each->get_name());
  return nearest_name(word, names);
}

}  // namespace

std::string unknown_argument(const CLI::App& command, const std::vector<std::string>& words) {
  const std::string& word = words.front();
  const bool is_option = word.size() > 1 && word.starts_with('-');
  const bool is_command = !is_option && !subcommands(command).empty();
  const std::string name = is_option ? word.substr(0, word.find('=')) : word;
  std::string meant = is_option    ? meant_option(command, name)
                      : is_command ? meant_command(command, name)
                                   : meant_probe(command, words);
  if (meant.empty() && !is_option && !is_command) meant = meant_output(command, word);
  const std::string path = command_path(command);
  const std::string help =
      fmt::format("{} {}{}--help", program_of(command).get_name(), path, path.empty() ? "" : " ");
  const std::string sentence = fmt::format("there is no {} \"{}\"",
                                           is_option    ? "option"
                                           : is_command ? "command"
                                                        : "argument",
                                           printable(name));
  return meant.empty() ? fmt::format("{}, expected one that `{}` lists", sentence, help)
                       : fmt::format("{}, did you mean {}? `{}` lists all", sentence, meant, help);
}

}  // namespace fanlight
