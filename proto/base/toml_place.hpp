// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace fanlight {

// Places in a TOML file, from 1 on. Templates, since toml11 4 (Debian 13) has other classes than toml11 3.

/// Where a text is no TOML. `Failure` is toml::syntax_error.
template <typename Failure>
std::size_t toml_error_line(const Failure& failure) {
  if constexpr (requires { failure.location(); }) {
    return failure.location().line();
  } else {
    const auto& errors = failure.errors();
    const bool has_place = !errors.empty() && !errors.front().locations().empty();
    return has_place ? errors.front().locations().front().first.first_line_number() : 1;
  }
}

/// The first line of a value. `Location` is toml::source_location.
template <typename Location>
std::size_t toml_line(const Location& location) {
  if constexpr (requires { location.first_line_number(); }) {
    return location.first_line_number();
  } else {
    return location.line();
  }
}

}  // namespace fanlight
