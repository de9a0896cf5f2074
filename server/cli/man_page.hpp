// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <string>

namespace fanlight {

/// The manual page of a command in the language of man(7), made of its option table: section 1, named
/// fanlight or fanlight-COMMAND. It has no date, so that two builds are alike.
std::string man_page(const CLI::App& command);

}  // namespace fanlight
