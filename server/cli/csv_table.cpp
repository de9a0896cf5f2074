// SPDX-License-Identifier: Apache-2.0
#include "server/cli/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fanlight {

namespace {

class CsvParser {
 public:
  explicit CsvParser(std::string_view text) : text_(text) {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (text_.starts_with(kByteOrderMark)) text_.remove_prefix(kByteOrderMark.size());
  }

  Result<std::vector<CsvRow>> parse() {
    std::vector<CsvRow> rows;
    while (!text_.empty()) {
      CsvRow row{.line = line_, .cells = {}};
      if (auto read = read_row(row); !read) return read.error();
      const bool is_empty = row.cells.size() == 1 && row.cells.front().empty();
      if (is_empty) continue;
      if (!rows.empty() && row.cells.size() != rows.front().cells.size())
        return bad(row.line, fmt::format("the row has {} cells, expected {} as in the first row",
                                         row.cells.size(), rows.front().cells.size()));
      rows.push_back(std::move(row));
    }
    return rows;
  }

 private:
  static Error bad(std::size_t line, const std::string& wrong) {
    return {ErrorCode::kBadInput, fmt::format("line {}: {}", line, wrong)};
  }

  Result<void> read_row(CsvRow& row) {
    do {
      row.cells.emplace_back();
      auto read = text_.starts_with('"') ? read_quoted(row.cells.back()) : read_plain(row.cells.back());
      if (!read) return read;
    } while (take(","));
    if (!text_.empty() && !take("\r\n") && !take("\n"))
      return bad(line_, "text follows a closing quote, expected a comma or the end of the line");
    ++line_;
    return {};
  }

  Result<void> read_plain(std::string& cell) {
    const std::size_t end = std::min(text_.find_first_of(",\n"), text_.size());
    cell = text_.substr(0, end);
    text_.remove_prefix(end);
    if (cell.ends_with('\r')) cell.pop_back();
    return {};
  }

  Result<void> read_quoted(std::string& cell) {
    const std::size_t begun = line_;
    text_.remove_prefix(1);
    for (;;) {
      const std::size_t quote = text_.find('"');
      if (quote == std::string_view::npos) return bad(begun, "a quote is never closed");
      cell += text_.substr(0, quote);
      line_ += static_cast<std::size_t>(std::ranges::count(text_.substr(0, quote), '\n'));
      text_.remove_prefix(quote + 1);
      if (!take("\"")) return {};
      cell += '"';
    }
  }

  bool take(std::string_view what) {
    if (!text_.starts_with(what)) return false;
    text_.remove_prefix(what.size());
    return true;
  }

  std::string_view text_;
  std::size_t line_ = 1;
};

}  // namespace

Result<std::vector<CsvRow>> parse_csv(std::string_view text) {
  return CsvParser(text).parse();
}

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? "\"\"" : std::string(1, c);
  return cell + "\"";
}

}  // namespace fanlight
