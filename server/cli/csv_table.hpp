// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

struct CsvRow {
  std::size_t line = 0;  ///< where it begins, from 1 on
  std::vector<std::string> cells;
};

/// The rows of a table as RFC 4180 has them: cells with commas between them; in double quotes where a cell
/// has a comma, a line break or a quote, which is then doubled. Lines end with LF or CRLF; a byte order mark
/// and empty lines are passed over. Our own 40 lines: Debian's readers want the number of columns at compile
/// time, or call back for each cell. kBadInput, with the line: a quote that is never closed, text after a
/// closing one, or a row with another number of cells than the first.
Result<std::vector<CsvRow>> parse_csv(std::string_view text);

/// A cell as parse_csv() reads it.
std::string csv_cell(std::string_view text);

}  // namespace fanlight
