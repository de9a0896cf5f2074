// SPDX-License-Identifier: Apache-2.0
#include "server/access/audit_chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "server/access/digest.hpp"

namespace fanlight {

namespace {

using nlohmann::json;

std::string text_in(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::uint64_t number_in(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

bool is_entry_of_log(const json& line, const char* result) {
  return text_in(line, "what") == "audit" && text_in(line, "result") == result;
}

/// A file with the number of its first line, which says where it belongs.
struct Part {
  std::uint64_t first_line = 0;
  std::filesystem::path path;
};

/// What a server leaves that was ended while it rotated its log: a second name of the same file, or a new
/// file that has no name yet. The next start removes both.
bool is_left_by_rotation(std::size_t index, std::span<const std::filesystem::path> paths) {
  std::error_code unknown;
  const std::filesystem::path& path = paths[index];
  const bool is_next =
      path.extension() == kAuditNextSuffix &&
      std::ranges::find(paths, std::filesystem::path(path).replace_extension()) != paths.end();
  return is_next || std::ranges::any_of(paths.first(index), [&](const std::filesystem::path& other) {
           return std::filesystem::equivalent(path, other, unknown);
         });
}

Result<std::vector<Part>> parts_in_order(std::span<const std::filesystem::path> paths) {
  std::vector<Part> parts;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::filesystem::path& path = paths[i];
    if (is_left_by_rotation(i, paths)) continue;
    std::ifstream file(path);
    if (!file) {
      return Error{ErrorCode::kNotFound,
                   fmt::format("the audit log {} could not be read, expected a file", path.string())};
    }
    std::string first;
    std::getline(file, first);
    if (!first.empty()) parts.push_back({.first_line = audit_line_number(first), .path = path});
  }
  std::ranges::stable_sort(parts, {}, &Part::first_line);
  return parts;
}

Result<void> walk(AuditChain& chain, const std::filesystem::path& path) {
  std::ifstream file(path);
  for (std::string text; std::getline(file, text);) {
    if (file.eof() || !chain.take(text)) return broken_audit_chain(path, chain.position().line + 1);
  }
  return {};
}

}  // namespace

Error broken_audit_chain(const std::filesystem::path& path, std::uint64_t line) {
  return {ErrorCode::kBadInput, fmt::format("line {} of the audit log {} does not follow from the one before "
                                            "it: the log was changed or cut; expected it as it was written, "
                                            "or a new file",
                                            line, path.string())};
}

std::uint64_t audit_line_number(std::string_view text) {
  const auto line = json::parse(text, nullptr, false);
  return line.is_object() ? number_in(line, "line") : 0;
}

bool AuditChain::take(std::string_view text) {
  const auto line = json::parse(text, nullptr, false);
  if (!line.is_object()) return false;
  const std::uint64_t number = number_in(line, "line");
  const std::string follows = text_in(line, "follows");
  if (number == 0 || follows.size() != kAuditBeginning.size()) return false;
  const bool next = number == position_.line + 1 && follows == position_.hash;
  const bool may_begin =
      lines_ == 0 && (begin_ == Begin::kAnywhere ||
                      (begin_ == Begin::kOfFile && number > 1 && is_entry_of_log(line, kAuditContinues)));
  if (!next && !may_begin) return false;
  if (lines_++ == 0) {
    first_line_ = number;
    first_follows_ = follows;
  }
  if (is_entry_of_log(line, kAuditLost) && line.contains("details") && line["details"].is_object()) {
    lost_ += number_in(line["details"], "count");
  }
  position_ = {.line = number, .hash = hex(sha256(text))};
  return true;
}

Result<AuditSummary> verify_audit_logs(std::span<const std::filesystem::path> paths) {
  const auto parts = parts_in_order(paths);
  if (!parts) return parts.error();
  AuditChain chain(AuditChain::Begin::kOfFile);
  for (const Part& part : *parts) {
    if (auto walked = walk(chain, part.path); !walked) return walked.error();
  }
  if (chain.lines() == 0) return AuditSummary{};
  return AuditSummary{.lines = chain.lines(),
                      .first_line = chain.first_line(),
                      .first_follows = chain.first_follows(),
                      .newest_hash = chain.position().hash,
                      .lost = chain.lost()};
}

Result<AuditSummary> verify_audit_log(const std::filesystem::path& path) {
  return verify_audit_logs(std::span(&path, 1));
}

}  // namespace fanlight
