// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <utility>
#include <vector>

namespace fanlight {

/// Adds an option that takes one of some names. `value` must live as long as the command, and keeps its value
/// if the option is not given; `usual` is its name for --help, empty where it depends. (CLI11's own
/// transformer prints small enumerations as unprintable characters.)
template <typename Value, typename Choice>
CLI::Option* add_named_option(CLI::App& command, const std::string& name, Value& value,
                              std::vector<std::pair<std::string, Choice>> choices, const std::string& help,
                              const std::string& usual = "") {
  std::vector<std::string> names;
  std::string shown;
  for (const auto& choice : choices) {
    names.push_back(choice.first);
    shown += (shown.empty() ? "" : "|") + choice.first;
  }
  return command
      .add_option_function<std::string>(
          name,
          [&value, choices = std::move(choices)](const std::string& given) {
            for (const auto& [known, choice] : choices) {
              if (known == given) value = choice;
            }
          },
          help)
      ->check(CLI::IsMember(names).description(""))
      ->default_str(usual)
      ->type_name(shown);
}

}  // namespace fanlight
