// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

namespace fanlight {

/// The sentence about the first of the words that a command does not take, with what was meant: an option
/// with a similar name or another program's name for it, a file for --out, an option of the simulated probe
/// after a space instead of a comma. Precondition: there is a word.
std::string unknown_argument(const CLI::App& command, const std::vector<std::string>& words);

}  // namespace fanlight
