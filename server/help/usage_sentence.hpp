// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>

namespace fanlight {

/// A command line that is not understood: which command, and what is wrong with it.
struct UsageError {
  std::string command;  ///< "fanlight token add"
  std::string sentence;
};
UsageError usage_error(const CLI::App& program, const CLI::ParseError& error);

/// The sentence for people of what CLI11 says about a value or an option that it refuses: "--ring is 2,
/// expected 3 to 64" in place of "--ring: Value 2 not in range 3 to 64". What it does not know comes back as
/// it is.
std::string usage_sentence(const std::string& of_cli11);

}  // namespace fanlight
