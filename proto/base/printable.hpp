// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace fanlight {

/// Whether a text from outside may be shown as it is, on a terminal, in a log and on a page: valid UTF-8
/// without control characters (C0, DEL, C1), line and paragraph separators, and characters that are invisible
/// or change the direction of the text around them.
bool is_printable(std::string_view text);

/// `text` with '?' for each character that is_printable() refuses, and for each byte that is no UTF-8.
std::string printable(std::string_view text);

}  // namespace fanlight
