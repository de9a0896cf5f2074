// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "acquisition/open_source.hpp"

namespace fanlight {

/// Adds the options of a USB probe to a command; `options` must live as long as the command.
void add_probe_options(CLI::App& command, SourceOptions& options);

}  // namespace fanlight
