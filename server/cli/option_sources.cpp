// SPDX-License-Identifier: Apache-2.0
#include "server/cli/option_sources.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <toml.hpp>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "proto/base/nearest_name.hpp"
#include "proto/base/printable.hpp"
#include "proto/base/toml_excess.hpp"
#include "proto/base/toml_place.hpp"
#include "server/help/option_table.hpp"
#include "server/help/usage_sentence.hpp"

namespace fanlight {

namespace {

constexpr const char* kCommandLine = "command line";
constexpr const char* kVariable = "FANLIGHT_";

/// What decides about the configuration is not part of it.
bool is_configured(const OptionRow& row) {
  const std::string key = row.key();
  return !key.empty() && key != "config" && key != "print-config" && key != "help" && key != "help-all";
}

std::vector<OptionRow> configured_rows(const CLI::App& command) {
  std::vector<OptionRow> rows;
  for (const OptionGroup& group : option_table(command))
    for (const OptionRow& row : group.rows)
      if (is_configured(row)) rows.push_back(row);
  return rows;
}

Error bad(const std::string& place, const std::string& wrong) {
  return {ErrorCode::kInvalidArgument, fmt::format("{}: {}", place, wrong)};
}

/// A value as the command line would have it; absent: it is none of these.
std::optional<std::string> text_of(const toml::value& value) {
  if (value.is_string()) return toml::get<std::string>(value);
  if (value.is_boolean()) return toml::get<bool>(value) ? "true" : "false";
  if (value.is_integer()) return std::to_string(toml::get<std::int64_t>(value));
  if (value.is_floating()) return fmt::format("{}", toml::get<double>(value));
  return std::nullopt;
}

struct PlacedOption {
  std::size_t line;
  ConfiguredOption option;
};

Result<void> collect(const std::string& file, const std::string& prefix, const toml::value& table,
                     std::vector<PlacedOption>& options) {
  for (const auto& [key, value] : table.as_table()) {
    const std::string name = prefix + key;
    if (value.is_table()) {
      if (auto inner = collect(file, name + ".", value, options); !inner) return inner;
      continue;
    }
    const bool has_tables = value.is_array() && !value.as_array().empty() && value.as_array()[0].is_table();
    if (has_tables) {
      std::size_t number = 0;
      for (const auto& each : value.as_array()) {
        const std::string own = fmt::format("{}.{}", name, number++);
        if (each.as_table().empty()) {
          const std::size_t line = toml_line(each.location());
          options.push_back(
              {line, {.name = own, .value = "", .from = fmt::format("{}, line {}", file, line)}});
        } else if (auto inner = collect(file, own + ".", each, options); !inner) {
          return inner;
        }
      }
      continue;
    }
    const std::size_t line = toml_line(value.location());
    const std::string place = fmt::format("{}, line {}", file, line);
    const auto text = text_of(value);
    if (!text)
      return bad(place, fmt::format("{} is neither text nor a number nor true or false", printable(name)));
    options.push_back({line, {.name = name, .value = *text, .from = place}});
  }
  return {};
}

std::string variable_of(const std::string& key) {
  std::string name = kVariable;
  for (const char c : key)
    name += c == '-' || c == '.' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

/// Whether a TOML file may have it without quotes, and reads it back as the same letters.
bool is_number(const std::string& text) {
  const char* const end = text.data() + text.size();
  std::int64_t whole = 0;
  const auto as_whole = std::from_chars(text.data(), end, whole);
  if (as_whole.ec == std::errc{} && as_whole.ptr == end) return std::to_string(whole) == text;
  double number = 0;
  const auto as_number = std::from_chars(text.data(), end, number);
  return as_number.ec == std::errc{} && as_number.ptr == end && text.find('.') != std::string::npos &&
         fmt::format("{}", number) == text;
}

/// A basic string of TOML in one line; toml11 breaks long ones.
std::string quoted_text(const std::string& text) {
  std::string safe = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      safe += '\\';
      safe += c;
    } else if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') {
      safe += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    } else {
      safe += c;
    }
  }
  return safe + "\"";
}

std::string toml_text(const OptionRow& row, const std::string& value) {
  return row.flag() || is_number(value) ? value : quoted_text(value);
}

/// Stands for a value where there is no default.
std::string sample(const OptionRow& row) {
  if (!row.choices.empty()) return toml_text(row, row.choices.front());
  constexpr std::string_view kTexts[] = {"FILE", "FOLDER", "NAME", "ORIGINS", "TEXT"};
  return std::ranges::find(kTexts, row.value) != std::end(kTexts) ? toml_text(row, row.value)
                                                                  : fmt::format("<{}>", row.value);
}

Result<void> give(CLI::Option& option, const OptionRow& row, const ConfiguredOption& given) {
  if (row.flag()) {
    if (given.value == "false" || given.value == "0") return {};
    if (given.value != "true" && given.value != "1")
      return bad(given.from,
                 fmt::format("{} is {}, expected true or false", given.name, printable(given.value)));
  }
  try {
    option.add_result(row.flag() ? "true" : given.value);
    option.run_callback();
  } catch (const CLI::Error& refusal) {
    // CLI11 names the option in some of its sentences.
    std::string sentence = printable(usage_sentence(refusal.what()));
    // A file and the environment have no dashes.
    if (sentence.starts_with("--")) sentence.erase(0, 2);
    return bad(given.from, sentence.find(given.name) == std::string::npos
                               ? fmt::format("{}: {}", given.name, sentence)
                               : sentence);
  }
  return {};
}

/// The sentence about a name that no option has.
std::string unknown_name(const std::string& name, const std::vector<OptionRow>& rows,
                         const std::string& command) {
  // What follows a [section] of TOML belongs to it.
  const std::string own = name.substr(name.rfind('.') + 1);
  if (own != name && std::ranges::find(rows, own, &OptionRow::key) != rows.end()) {
    return fmt::format("there is no option {}, expected {} above the first line such as [{}]",
                       printable(name), own, printable(name.substr(0, name.rfind('.'))));
  }
  std::vector<std::string> known;
  known.reserve(rows.size());
  for (const OptionRow& option : rows) known.push_back(option.key());
  const std::string meant = nearest_name(name, known);
  return fmt::format("there is no option {}, {}", printable(name),
                     meant.empty() ? fmt::format("expected one that fanlight {} --help-all lists", command)
                                   : fmt::format("did you mean {}?", meant));
}

/// Whether it is given, and not as false.
bool is_set(const OptionRow& row) {
  return row.option->count() > 0 && (!row.flag() || row.option->as<bool>());
}

bool is_set(const CLI::Option& option) {
  return option.count() > 0 && (option.get_items_expected_max() > 0 || option.as<bool>());
}

std::string origin_of(const CLI::Option& option, const OptionOrigins& origins) {
  const auto found = origins.find(option.get_lnames().front());
  return found == origins.end() ? "" : fmt::format(" ({})", found->second);
}

}  // namespace

Result<std::vector<ConfiguredOption>> read_configuration(const std::filesystem::path& path,
                                                         const OptionsFile& kind) {
  const std::string name = printable(path.string());
  const auto unreadable = [&name, &kind](const std::string& why) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the {} {} {}, expected a TOML file of at most {} MB", kind.name, name, why,
                             kind.most_bytes / 1'000'000)};
  };
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (status.type() == std::filesystem::file_type::not_found) return unreadable("is not there");
  if (failure) return unreadable(fmt::format("cannot be read ({})", failure.message()));
  // A pipe would wait for a writer.
  if (!std::filesystem::is_regular_file(status)) return unreadable("is no file");
  const std::uintmax_t bytes = std::filesystem::file_size(path, failure);
  if (failure) return unreadable(fmt::format("cannot be read ({})", failure.message()));
  if (bytes > kind.most_bytes) return unreadable("is too large");
  std::ifstream file(path, std::ios::binary);
  if (!file) return unreadable("may not be read by this user");
  std::string text(bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() != bytes) return unreadable("has changed while it was read");
  if (const std::string excess = toml_excess(text); !excess.empty())
    return bad(name, fmt::format("{}, expected lines such as {}", excess, kind.line));
  std::vector<PlacedOption> options;
  try {
    std::istringstream stream(text);
    const toml::value whole = toml::parse(stream, path.string());
    if (auto collected = collect(name, "", whole, options); !collected) return collected.error();
  } catch (const toml::syntax_error& wrong) {
    const std::string place = fmt::format("{}, line {}", name, toml_error_line(wrong));
    if (std::string_view(wrong.what()).find("already exists") != std::string_view::npos)
      return bad(place, "it is given twice, expected each name once");
    return bad(fmt::format("{}, line {}", name, toml_error_line(wrong)),
               fmt::format("it is not TOML, expected a line such as {}", kind.line));
  } catch (const std::exception&) {
    return bad(name, fmt::format("it is not TOML, expected lines such as {}", kind.line));
  }
  std::ranges::stable_sort(options, {}, &PlacedOption::line);
  std::vector<ConfiguredOption> sorted;
  sorted.reserve(options.size());
  for (PlacedOption& each : options) sorted.push_back(std::move(each.option));
  return sorted;
}

std::vector<ConfiguredOption> command_line_options(const CLI::App& command) {
  std::vector<ConfiguredOption> given;
  for (const OptionRow& row : configured_rows(command)) {
    if (row.option->count() == 0) continue;
    const std::string value = row.flag()                      ? (row.option->as<bool>() ? "true" : "false")
                              : row.option->results().empty() ? ""
                                                              : row.option->results().front();
    given.push_back({.name = row.key(), .value = value, .from = kCommandLine});
  }
  return given;
}

bool is_of_command_line(const std::string& origin) {
  return origin == kCommandLine;
}

bool comes_before_file(const std::string& origin) {
  return is_of_command_line(origin) || origin.starts_with(kVariable);
}

std::vector<ConfiguredOption> environment_options(const CLI::App& command) {
  std::vector<ConfiguredOption> given;
  for (const OptionRow& row : configured_rows(command)) {
    const std::string variable = variable_of(row.key());
    // NOLINTNEXTLINE(concurrency-mt-unsafe): no other thread runs yet
    const char* const value = std::getenv(variable.c_str());
    if (value != nullptr && *value != '\0')
      given.push_back({.name = row.key(), .value = value, .from = variable});
  }
  return given;
}

std::vector<std::string> misspelt_variables(const CLI::App& command) {
  // Of other programs of the project, and of clients.
  std::vector<std::string> known = {"TOKEN", "CONFIG"};
  const std::size_t prefix = std::string_view(kVariable).size();
  for (const OptionRow& row : configured_rows(command))
    known.push_back(variable_of(row.key()).substr(prefix));
  std::vector<std::string> sentences;
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) {
    const std::string_view whole = *variable;
    if (!whole.starts_with(kVariable)) continue;
    const std::string_view name = whole.substr(prefix, whole.find('=') - prefix);
    if (std::ranges::find(known, name) != known.end()) continue;
    if (const std::string meant = nearest_name(name, known); !meant.empty()) {
      sentences.push_back(fmt::format("the variable {}{} sets nothing, did you mean {}{}?", kVariable,
                                      printable(name), kVariable, meant));
    }
  }
  return sentences;
}

Result<void> apply_options(CLI::App& command, const std::vector<ConfiguredOption>& given,
                           const ValueCheck& check, OptionOrigins& origins) {
  const std::vector<OptionRow> rows = configured_rows(command);
  for (const ConfiguredOption& each : given) {
    const auto row = std::ranges::find(rows, each.name, &OptionRow::key);
    if (row == rows.end()) return bad(each.from, unknown_name(each.name, rows, command.get_name()));
    if (!origins.emplace(each.name, each.from).second) continue;
    CLI::Option& option = *command.get_option("--" + row->key());
    if (option.count() > 0) continue;  // the command line's own
    if (auto taken = give(option, *row, each); !taken) return taken;
    if (auto good = check(each.name, each.value); !good) return bad(each.from, good.error().message);
  }
  return {};
}

Result<void> check_together(const CLI::App& command, const OptionOrigins& origins) {
  for (const OptionRow& row : configured_rows(command)) {
    if (!is_set(row)) continue;
    const std::string name = "--" + row.key() + origin_of(*row.option, origins);
    for (const CLI::Option* const other : row.option->get_needs()) {
      if (!is_set(*other))
        return Error{ErrorCode::kInvalidArgument,
                     fmt::format("{} needs {}, expected both", name, other->get_name())};
    }
    for (const CLI::Option* const other : row.option->get_excludes()) {
      if (is_set(*other))
        return Error{ErrorCode::kInvalidArgument,
                     fmt::format("{} and {}{} exclude one another, expected one of them", name,
                                 other->get_name(), origin_of(*other, origins))};
    }
  }
  return {};
}

std::string configuration_text(const CLI::App& command, const OptionOrigins& origins) {
  std::string text = fmt::format(
      "# Configuration of fanlight {0}, read with: fanlight {0} --config FILE\n"
      "# A line that begins with \"# \" and a name has the default. Each option can also be given on the\n"
      "# command line (--listen) or in the environment (FANLIGHT_LISTEN), which come first.\n",
      command.get_name());
  for (const OptionGroup& group : option_table(command)) {
    bool headed = false;
    for (const OptionRow& row : group.rows) {
      if (!is_configured(row)) continue;
      if (!std::exchange(headed, true)) text += fmt::format("\n## {}\n", group.name);
      text += fmt::format("\n# {}\n", row.text);
      const std::string key = row.key();
      if (origins.contains(key)) {
        const std::string value =
            row.flag() ? (is_set(row) ? "true" : "false") : row.option->results().front();
        text += fmt::format("{} = {}  # {}\n", key, toml_text(row, value), origins.at(key));
      } else if (row.flag()) {
        text += fmt::format("# {} = false\n", key);
      } else {
        text += fmt::format("# {} = {}\n", key, row.usual.empty() ? sample(row) : toml_text(row, row.usual));
      }
    }
  }
  return text;
}

}  // namespace fanlight
