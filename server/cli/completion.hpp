// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <string_view>

#include "proto/base/result.hpp"

namespace fanlight {

/// The script that completes commands, options and their values in a shell: bash, zsh or fish. Made of the
/// option table. Errors: another shell.
Result<std::string> completion_script(const CLI::App& program, std::string_view shell);

}  // namespace fanlight
