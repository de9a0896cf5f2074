// SPDX-License-Identifier: Apache-2.0
#include "server/access/audit_entry.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string_view>

#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

std::string time_text() {
  const auto now = std::chrono::system_clock::now();
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()) % 1000;
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(now)),
                     ms.count());
}

}  // namespace

bool is_refusal(const AuditEvent& event) {
  return event.result.starts_with("refused");
}

bool is_act_of_control(const AuditEvent& event) {
  constexpr auto kActs = std::to_array<std::string_view>({"control", "probe_change", "scene_change"});
  return !is_refusal(event) && std::ranges::find(kActs, std::string_view(event.what)) != kActs.end();
}

std::string audit_fields(const Principal& who, const AuditEvent& event, const nlohmann::json& details) {
  nlohmann::ordered_json line = {
      {"time", time_text()}, {"what", event.what},  {"who", who.name},          {"role", role_name(who.role)},
      {"proof", who.proof},  {"from", who.address}, {"session", event.session}, {"result", event.result}};
  if (!details.is_null()) line["details"] = details;
  // JSON escapes line ends and the like by itself. All else that does not print is inside of its strings.
  const std::string text =
      printable(line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  return text.substr(1, text.size() - 2);
}

std::string audit_fields_of_log(const std::string& result, const nlohmann::json& details) {
  return audit_fields({.name = "fanlight"}, {.what = "audit", .result = result}, details);
}

}  // namespace fanlight
