// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <utility>
#include <vector>

namespace fanlight {

/// Adds an option that takes one of some names. `value` must live as long as the command, and keeps its value
/// if the option is not given. (CLI11's own transformer prints small enumerations as unprintable characters.)
template <typename Value, typename Choice>
CLI::Option* add_named_option(CLI::App& command, const std::string& name, Value& value,
                              std::vector<std::pair<std::string, Choice>> choices, const std::string& help) {
  std::vector<std::string> names;
  names.reserve(choices.size());
  for (const auto& choice : choices) names.push_back(choice.first);
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
      ->type_name("NAME");
}

}  // namespace fanlight
