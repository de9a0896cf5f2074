// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "acquisition/open_source.hpp"

namespace fanlight {

/// Adds the options of a USB probe to a command; `options` must live as long as the command.
void add_probe_options(CLI::App& command, SourceOptions& options);

/// What is waited for while a source is opened, for the user; empty: it is opened at once.
std::string opening_note(const std::string& source, const SourceOptions& options);

}  // namespace fanlight
