// SPDX-License-Identifier: Apache-2.0
#include "server/access/audit_log.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

namespace fanlight {

namespace {

// The previous hash of the first line.
constexpr std::string_view kBeginning = "0000000000000000000000000000000000000000000000000000000000000000";

std::string time_text() {
  const auto now = std::chrono::system_clock::now();
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()) % 1000;
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(now)),
                     ms.count());
}

}  // namespace

AuditLog::AuditLog(AuditLog&& other) noexcept {
  *this = std::move(other);
}

AuditLog& AuditLog::operator=(AuditLog&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(lines_, other.lines_);
  std::swap(lines_lost_, other.lines_lost_);
  std::swap(newest_hash_, other.newest_hash_);
  std::swap(bytes_, other.bytes_);
  std::swap(refusals_left_, other.refusals_left_);
  std::swap(refusals_unlisted_, other.refusals_unlisted_);
  return *this;
}

AuditLog::~AuditLog() {
  if (file_ >= 0) close(file_);
}

Result<AuditLog> AuditLog::open(const std::filesystem::path& path) {
  AuditLog made;
  made.newest_hash_ = kBeginning;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(path, ignored)) {  // a pipe has no lines to read
    const auto summary = verify_audit_log(path);
    if (!summary) return summary.error();
    made.lines_ = summary->lines;
    if (summary->lines > 0) made.newest_hash_ = summary->newest_hash;
  }
  made.file_ = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (made.file_ < 0) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("the audit log {} could not be opened ({}), expected a file to append to",
                             path.string(), std::generic_category().message(errno))};
  }
  struct stat status {};
  if (fstat(made.file_, &status) == 0) made.bytes_ = static_cast<std::uint64_t>(status.st_size);
  return made;
}

void AuditLog::note(const Principal& who, const Event& event) {
  note(who, event, nullptr);
}

void AuditLog::note(const Principal& who, const Event& event, const nlohmann::json& details) {
  if (file_ < 0) return;
  nlohmann::ordered_json line = {
      {"line", lines_ + 1},  {"time", time_text()},         {"what", event.what},
      {"who", who.name},     {"role", role_name(who.role)}, {"proof", who.proof},
      {"from", who.address}, {"session", event.session},    {"result", event.result}};
  if (!details.is_null()) line["details"] = details;
  line["follows"] = newest_hash_;
  // Details can hold text from a client: bytes that are not UTF-8 are replaced.
  const std::string text = line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  if (write(file_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    ++lines_lost_;
    // An incomplete line would break the chain.
    if (ftruncate(file_, static_cast<off_t>(bytes_)) != 0) close(std::exchange(file_, -1));
    return;
  }
  bytes_ += text.size();
  ++lines_;
  newest_hash_ = hex(sha256(std::string_view(text).substr(0, text.size() - 1)));
}

void AuditLog::note_refusal(const Principal& who, const Event& event) {
  note_refusal(who, event, nullptr);
}

void AuditLog::note_refusal(const Principal& who, const Event& event, const nlohmann::json& details) {
  if (refusals_left_ <= 0) {
    ++refusals_unlisted_;
    return;
  }
  --refusals_left_;
  note(who, event, details);
}

void AuditLog::second_passed() {
  refusals_left_ = kRefusalsASecond;
  const std::uint64_t unlisted = std::exchange(refusals_unlisted_, 0);
  if (unlisted > 0) {
    note({.name = "fanlight"}, {.what = "refusals", .result = "more than are listed"},
         {{"unlisted", unlisted}});
  }
}

Result<AuditSummary> verify_audit_log(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) {
    return Error{ErrorCode::kNotFound,
                 fmt::format("the audit log {} could not be read, expected a file", path.string())};
  }
  AuditSummary summary{.newest_hash = std::string(kBeginning)};
  for (std::string text; std::getline(file, text);) {
    const auto line = nlohmann::json::parse(text, nullptr, false);
    const bool follows = line.is_object() && line.contains("line") && line["line"] == summary.lines + 1 &&
                         line.contains("follows") && line["follows"] == summary.newest_hash;
    if (!follows || file.eof()) {
      return Error{ErrorCode::kBadInput, fmt::format("line {} of the audit log {} does not follow from the "
                                                     "one before it: the log was changed or cut; "
                                                     "expected it as it was written, or a new file",
                                                     summary.lines + 1, path.string())};
    }
    ++summary.lines;
    summary.newest_hash = hex(sha256(text));
  }
  if (summary.lines == 0) summary.newest_hash.clear();
  return summary;
}

}  // namespace fanlight
