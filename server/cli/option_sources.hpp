// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

/// An option that a configuration sets: `listen = "127.0.0.1:8080"` or `detector.threshold = 30`.
struct ConfiguredOption {
  std::string name;   ///< without dashes: "listen", "detector.threshold"
  std::string value;  ///< as on the command line; "true" or "false" for an option without a value
  std::string from;   ///< "fanlight.toml, line 12" or "FANLIGHT_LISTEN"
};

/// What a TOML file is, for the sentences that refuse it.
struct OptionsFile {
  const char* name = "configuration";
  const char* line = "listen = \"127.0.0.1:8080\"";  ///< as an example
  std::uintmax_t most_bytes = 1'000'000;
};

/// The options in a TOML file, in the order of their lines. A table gives its name and a dot to those in it;
/// an array of tables also the number of the table, from 0 on: "sweep.17.size". Errors: no file, no TOML
/// (with the line), or a value that is no text, number or truth value.
Result<std::vector<ConfiguredOption>> read_configuration(const std::filesystem::path& path,
                                                         const OptionsFile& kind = {});

/// The options of a command that the environment sets: FANLIGHT_LISTEN for --listen,
/// FANLIGHT_DETECTOR_THRESHOLD for --detector.threshold.
std::vector<ConfiguredOption> environment_options(const CLI::App& command);

/// A sentence for each variable that begins with FANLIGHT_ and sets nothing, but is spelt almost like one
/// that does.
std::vector<std::string> misspelt_variables(const CLI::App& command);

/// Where the value of each option comes from, by its name: "command line", the name of a variable, or the
/// place in a file. Those with their default are not in it.
using OptionOrigins = std::map<std::string, std::string>;

/// What the command line gave. Call it after that was read, and before anything else.
std::vector<ConfiguredOption> command_line_options(const CLI::App& command);

/// Whether the command line gave it: then a refusal needs no place.
bool is_of_command_line(const std::string& origin);

/// Whether the command line or the environment gave it.
bool comes_before_file(const std::string& origin);

/// Refuses a value that is only used later, such as one of the scene; with the name of its option.
using ValueCheck = std::function<Result<void>(const std::string& name, const std::string& value)>;

/// Gives these values to the options that have none of an earlier source, and notes where each comes from.
/// Errors: a name that is not known (with the nearest), a value that is refused (both with their place).
Result<void> apply_options(CLI::App& command, const std::vector<ConfiguredOption>& given,
                           const ValueCheck& check, OptionOrigins& origins);

/// Refuses options without those that they need, and with those that they exclude.
Result<void> check_together(const CLI::App& command, const OptionOrigins& origins);

/// All options of a command as a TOML file with comments, in the values in force. Those that have their
/// default, or none, are commented out.
std::string configuration_text(const CLI::App& command, const OptionOrigins& origins);

}  // namespace fanlight
