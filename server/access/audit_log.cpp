// SPDX-License-Identifier: Apache-2.0
#include "server/access/audit_log.hpp"

#include <chrono>
#include <new>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/access/audit_budget.hpp"
#include "server/access/audit_file.hpp"
#include "server/access/audit_writer.hpp"

namespace fanlight {

AuditLog::AuditLog() = default;
AuditLog::AuditLog(AuditLog&& other) noexcept = default;
AuditLog& AuditLog::operator=(AuditLog&& other) noexcept = default;
AuditLog::~AuditLog() = default;

Result<AuditLog> AuditLog::open(const std::filesystem::path& path, std::uint64_t rotate_bytes) {
  auto file = AuditFile::open(path, rotate_bytes);
  if (!file) return file.error();
  AuditLog made;
  made.budget_ = std::make_unique<AuditBudget>();
  made.writer_ = std::make_unique<AuditWriter>(std::move(*file));
  return made;
}

void AuditLog::note(const Principal& who, const Event& event) {
  thread_owner_.check();
  note(who, event, nullptr);
}

void AuditLog::note(const Principal& who, const Event& event, const nlohmann::json& details) {
  thread_owner_.check();
  if (writer_ == nullptr) return;
  try {
    if (budget_->take(who, event, details)) append(who, event, details);
  } catch (const std::bad_alloc&) {
    writer_->lose();  // the act itself continues
  }
}

void AuditLog::append(const Principal& who, const Event& event, const nlohmann::json& details) {
  writer_->push(audit_fields(who, event, details),
                is_act_of_control(event) ? AuditWriter::Urgency::kNow : AuditWriter::Urgency::kWithinASecond);
}

void AuditLog::append_folded(bool all) {
  for (const AuditBudget::Folded& one : all ? budget_->end() : budget_->second_passed()) {
    nlohmann::json details = {{"count", one.count}};
    if (!one.newest.is_null()) details["newest"] = one.newest;
    append(one.who, one.event, details);
  }
  if (const std::uint64_t unlisted = budget_->take_refusals_unlisted(); unlisted > 0) {
    append({.name = "fanlight"}, {.what = "refusals", .result = "more than are listed"},
           {{"unlisted", unlisted}});
  }
}

void AuditLog::second_passed() {
  thread_owner_.check();
  if (writer_ != nullptr) append_folded(false);
}

void AuditLog::reopen() {
  thread_owner_.check();
  if (writer_ != nullptr) writer_->reopen();
}

bool AuditLog::wait_until_written() {
  return writer_ == nullptr || writer_->wait_until_written(std::chrono::seconds(10));
}

bool AuditLog::close() {
  if (writer_ == nullptr) return true;
  append_folded(true);
  return writer_->end(std::chrono::seconds(2));
}

AuditPosition AuditLog::newest() const {
  return writer_ == nullptr ? AuditPosition{} : writer_->position();
}

bool AuditLog::refuses_acts() const {
  return is_required_ && (writer_ == nullptr || !writer_->can_write());
}

std::uint64_t AuditLog::lines_lost() const {
  return writer_ == nullptr ? 0 : writer_->lost();
}

std::string AuditLog::take_notice() {
  return writer_ == nullptr ? std::string() : writer_->take_notice();
}

}  // namespace fanlight
