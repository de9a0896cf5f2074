// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace fanlight {

/// Gives a program and all of its commands the help of command_help(), with --help-all where there are rare
/// options. Call it after all options were added.
void use_command_help(CLI::App& program);

/// What --help prints: what the command does, its usage, examples, then its options by groups. `all`: with
/// the rare groups.
std::string command_help(const CLI::App& command, bool all);

/// How a command is called: "fanlight convert INPUT --out FILE [OPTIONS]".
std::string command_usage(const CLI::App& command);

/// What a command does, as a sentence.
std::string sentence_of(const CLI::App& command);

/// The sentence about a command that words such as "token lst" do not name, or do not name whole. Empty: they
/// name one.
std::string lacking_command(const CLI::App& program, const std::vector<std::string>& words);

}  // namespace fanlight
