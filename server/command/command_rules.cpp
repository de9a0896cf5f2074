// SPDX-License-Identifier: Apache-2.0
#include "server/command/command_rules.hpp"

#include <array>
#include <variant>

namespace fanlight {

namespace {

constexpr const char* kChangeRefusal =
    "this session is a viewer's, expected an operator's or an admin's for a change";
constexpr const char* kPresetRefusal = "a viewer saves no presets, expected the role of an operator";
constexpr const char* kMeasurementRefusal =
    "a viewer's measurements stay on its page, expected the role of an operator to keep one on the server";
constexpr const char* kArchiveRefusal =
    "a viewer sends nothing to the archive, expected the role of an operator";
constexpr const char* kRelayRefusal = "the pictures leave the room by this, expected the role of an admin";
constexpr const char* kTakeOverRefusal =
    "this session is not an admin's, expected it to be to take the control over";

constexpr bool kAnyClient = false;
constexpr bool kSessionsOnly = true;
using Counters = ServerCounters;
using Control = ControlRule;

/// In the order of the alternatives of ClientCommand.
constexpr auto kRules = std::to_array<CommandRule>({
    {"scene_change", Role::kOperator, kChangeRefusal, kAnyClient, Control::kAcquires,
     &Counters::scene_refusals, &Counters::scene_changes},
    {"private_view", Role::kViewer, "", kSessionsOnly, Control::kNone, &Counters::private_view_refusals,
     nullptr},
    {"private_view", Role::kViewer, "", kSessionsOnly, Control::kNone, &Counters::private_view_refusals,
     nullptr},
    {"probe_change", Role::kOperator, kChangeRefusal, kSessionsOnly, Control::kAcquires,
     &Counters::probe_refusals, &Counters::probe_changes},
    {"survey", Role::kOperator, kChangeRefusal, kSessionsOnly, Control::kFree, &Counters::survey_refusals,
     nullptr},
    {"fluid", Role::kViewer, "", kSessionsOnly, Control::kNone, &Counters::fluid_refusals, nullptr},
    {"recording", Role::kOperator, kChangeRefusal, kAnyClient, Control::kFree, &Counters::recording_refusals,
     nullptr},
    {"replay", Role::kOperator, kChangeRefusal, kAnyClient, Control::kFree, &Counters::replay_refusals,
     nullptr},
    {"cine", Role::kOperator, kChangeRefusal, kAnyClient, Control::kFree, &Counters::cine_refusals, nullptr},
    {"preset", Role::kOperator, kPresetRefusal, kAnyClient, Control::kNone, &Counters::preset_refusals,
     nullptr},
    {"measurement", Role::kOperator, kMeasurementRefusal, kAnyClient, Control::kNone,
     &Counters::measurement_refusals, nullptr},
    {"rtp", Role::kAdmin, kRelayRefusal, kAnyClient, Control::kNone, &Counters::rtp_refusals, nullptr},
    {"archive", Role::kOperator, kArchiveRefusal, kAnyClient, Control::kNone, &Counters::archive_refusals,
     nullptr},
    {"control", Role::kViewer, "", kSessionsOnly, Control::kNone, &Counters::control_refusals, nullptr},
});
static_assert(kRules.size() == std::variant_size_v<ClientCommand>, "a row for each command");

}  // namespace

CommandRule rule_of(const ClientCommand& command) {
  CommandRule rule = kRules.at(command.index());
  if (const auto* change = std::get_if<ChangeControl>(&command)) {
    if (change->wish == v1::ControlRequest::ASK) {
      rule.least_role = Role::kOperator;
      rule.role_refusal = kChangeRefusal;
    } else if (change->wish == v1::ControlRequest::TAKE_OVER) {
      rule.least_role = Role::kAdmin;
      rule.role_refusal = kTakeOverRefusal;
    }
  }
  return rule;
}

}  // namespace fanlight
