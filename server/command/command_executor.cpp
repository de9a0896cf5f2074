// SPDX-License-Identifier: Apache-2.0
#include "server/command/command_executor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "server/state/scene_json.hpp"
#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

using nlohmann::json;
using Refused = CommandResult::Refused;

std::int64_t now_ms() {
  return now_ns() / 1'000'000;
}

CommandResult refusal(Error error, Refused refused = Refused::kByCommand) {
  return {.refused = refused, .error = std::move(error)};
}

CommandResult result_of(const Result<void>& done) {
  return done ? CommandResult() : refusal(done.error());
}

/// Without names and values, which may be a patient's.
json measurement_details(const v1::MeasurementRequest& request) {
  const auto hex = [](std::uint64_t id) { return fmt::format("{:x}", id); };
  switch (request.wish_case()) {
    case v1::MeasurementRequest::kAdd: {
      const std::string kind = v1::Measurement::Kind_Name(request.add().kind());
      return {{"wish", "add"}, {"kind", kind}, {"id", hex(request.add().id())}};
    }
    case v1::MeasurementRequest::kRename:
      return {{"wish", "rename"}, {"id", hex(request.rename().id())}};
    case v1::MeasurementRequest::kRemove:
      return {{"wish", "remove"}, {"id", hex(request.remove())}};
    case v1::MeasurementRequest::kRemoveAll:
      return {{"wish", "remove_all"}};
    case v1::MeasurementRequest::WISH_NOT_SET:
      break;
  }
  return nullptr;
}

}  // namespace

CommandResult CommandExecutor::permission(const CommandRule& rule, const Requester& who) const {
  if (!has_role(who.identity.principal->role, rule.least_role))
    return refusal({ErrorCode::kInvalidArgument, rule.role_refusal}, Refused::kByRole);
  if (rule.control != ControlRule::kNone) {
    if (auto may = control_.may_change(who.identity.id); !may)
      return refusal(may.error(), Refused::kByControl);
  }
  if (who.audit.refuses_acts()) {
    return refusal({ErrorCode::kUnavailable,
                    "the audit log cannot be written, so nothing may be changed; expected room on its disk"},
                   Refused::kByAudit);
  }
  if (rule.needs_session && who.identity.id == 0)
    return refusal({ErrorCode::kInvalidArgument, "this needs a session, expected one at /stream"});
  return {};
}

void CommandExecutor::execute(const Requester& who, const ClientCommand& command, const Answer& answer) {
  thread_owner_.check();
  const CommandRule rule = rule_of(command);
  Outcome outcome{.result = permission(rule, who)};
  if (outcome.result) outcome = std::visit([&](const auto& each) { return apply(each, who); }, command);
  // Only a command that was accepted acquires control; it is free again where the probe refuses later.
  const bool acquired = outcome.result && acquire(rule, who.identity);
  if (outcome.waits_for == 0) return finish(who, command, outcome, answer, acquired);
  auto& waiting = std::holds_alternative<ChangeProbe>(command) ? probe_changes_ : looks_;
  waiting.push_back({outcome.waits_for, who, command, answer, acquired});
  if (acquired) notify_(Notice::kControl, 0);
}

bool CommandExecutor::acquire(const CommandRule& rule, const SessionIdentity& who) {
  if (rule.control != ControlRule::kAcquires || who.id == 0) return false;
  const bool held = control_.holds(who.id);
  (void)control_.use(who.party(), now_ms());
  return !held;
}

void CommandExecutor::finish(const Requester& who, const ClientCommand& command, const Outcome& outcome,
                             const Answer& answer, bool control_changed) {
  const CommandRule rule = rule_of(command);
  if (!outcome.result) {
    (state_.counters.*rule.refusals).add();
  } else if (rule.done != nullptr) {
    (state_.counters.*rule.done).add();
  }
  note(who, command, outcome);
  answer(outcome.result);
  if (control_changed) notify_(Notice::kControl, 0);
  if (!outcome.notice) return;
  // The session that changed the scene has it in its answer.
  notify_(*outcome.notice, *outcome.notice == Notice::kScene ? who.identity.id : 0);
}

void CommandExecutor::note(const Requester& who, const ClientCommand& command, const Outcome& outcome) const {
  const char* const name = rule_of(command).name;
  const CommandResult& result = outcome.result;
  if (!result) return who.audit.note(name, "refused: " + result.error.message, details(command, result));
  if (const auto* change = std::get_if<ChangeScene>(&command)) return who.audit.add_change(change->fields);
  if (outcome.audited != nullptr) who.audit.note(name, outcome.audited, details(command, result));
}

json CommandExecutor::details(const ClientCommand& command, const CommandResult& result) const {
  if (const auto* change = std::get_if<ChangeScene>(&command)) return change_json(change->fields);
  if (const auto* recorder = std::get_if<ControlRecorder>(&command)) {
    json details = {{"wish", recorder->wish ? recording_word(*recorder->wish) : "unknown"}};
    if (result) details["file"] = result.file;
    return details;
  }
  if (const auto* replay = std::get_if<ControlReplay>(&command))
    return {{"wish", replay_words(replay->request)}};
  if (const auto* cine = std::get_if<ControlCine>(&command)) return {{"wish", cine_words(cine->request)}};
  if (const auto* presets = std::get_if<ChangePresets>(&command)) {
    const v1::PresetRequest& request = presets->request;
    const bool removes = request.has_remove();
    return {{removes ? "remove" : "save", printable(removes ? request.remove() : request.save().name())}};
  }
  if (const auto* measurements = std::get_if<ChangeMeasurements>(&command))
    return measurement_details(measurements->request);
  if (const auto* relay = std::get_if<ControlRelay>(&command)) {
    return {{"wish", relay->sends ? "start" : "stop"},
            {"to", state_.relay != nullptr ? state_.relay->to() : ""}};
  }
  if (const auto* change = std::get_if<ChangeControl>(&command)) {
    return {{"wish", v1::ControlRequest::Wish_Name(change->wish)},
            {"in_control", control_.state().holder.session}};
  }
  return nullptr;
}

CommandResult CommandExecutor::reject(const Requester& who, const ClientCommand& kind, const Error& error,
                                      const json& details) {
  CommandRule rule = rule_of(kind);
  rule.needs_session = false;  // what cannot be read needs to be mended first
  CommandResult result = permission(rule, who);
  if (result) result = refusal(error);
  (state_.counters.*rule.refusals).add();
  who.audit.note(rule.name, "refused: " + result.error.message, details);
  return result;
}

// ---- each command

CommandExecutor::Outcome CommandExecutor::apply(const ChangeScene& change, const Requester& /*who*/) {
  CommandResult result;
  const auto applied = state_.scene_store.apply(change.fields, &result.field);
  if (!applied) {
    result.refused = Refused::kByCommand;
    result.error = applied.error();
    return {.result = std::move(result)};
  }
  return {.result = {}, .notice = *applied ? std::optional(Notice::kScene) : std::nullopt};
}

CommandExecutor::Outcome CommandExecutor::apply(const ChangeView& change, const Requester& who) {
  const std::uint64_t session = who.identity.id;
  CommandResult result;
  const bool had_view = state_.views.has(session);
  const auto changed = state_.views.change(session, change.fields, &result.field, now_ns());
  if (!changed) {
    result.refused = Refused::kByCommand;
    result.error = changed.error();
  }
  return {.result = std::move(result), .audited = had_view ? nullptr : "done"};
}

CommandExecutor::Outcome CommandExecutor::apply(const LeaveView& /*change*/, const Requester& who) {
  const bool left = state_.views.leave(who.identity.id);
  return {.result = {.view_ended = left}, .audited = left ? "left" : nullptr};
}

CommandExecutor::Outcome CommandExecutor::apply(const ChangeProbe& change, const Requester& who) {
  const auto waiting = std::ranges::count_if(
      probe_changes_, [&](const Pending& each) { return each.who.identity.id == who.identity.id; });
  // The answer comes later, and the session must be able to read meanwhile.
  if (static_cast<std::size_t>(waiting) >= kMostPendingProbeChanges) {
    return {.result = refusal({ErrorCode::kUnavailable,
                               fmt::format("{} changes of the probe are unanswered, expected a later request",
                                           kMostPendingProbeChanges)})};
  }
  const auto order = state_.probe.order(change.settings);
  if (!order) return {.result = refusal(order.error())};
  return {.waits_for = *order};
}

CommandExecutor::Outcome CommandExecutor::apply(const FindSurface& /*command*/, const Requester& /*who*/) {
  const auto requested = state_.surveys.request(last_asker_ + 1);
  if (!requested) return {.result = refusal(requested.error())};
  return {.waits_for = ++last_asker_};
}

CommandExecutor::Outcome CommandExecutor::apply(const MeasureFluid& command, const Requester& who) {
  if (state_.cine.volume_id() != command.question.volume_id) {
    return {.result = refusal({ErrorCode::kInvalidArgument,
                               "this volume is not frozen, expected a point of the frozen volume on show"})};
  }
  const auto earlier = std::ranges::find_if(looks_, [&](const Pending& each) {
    return each.who.identity.id == who.identity.id && std::holds_alternative<MeasureFluid>(each.command);
  });
  if (earlier != looks_.end()) {
    const Pending replaced = std::move(*earlier);
    looks_.erase(earlier);
    state_.fluid.forget(replaced.order);
    replaced.answer(refusal({ErrorCode::kStopped, "a later request of this session has replaced this one"}));
  }
  const auto requested = state_.fluid.request(last_asker_ + 1, command.question);
  if (!requested) return {.result = refusal(requested.error())};
  return {.waits_for = ++last_asker_};
}

CommandExecutor::Outcome CommandExecutor::apply(const ControlRecorder& command, const Requester& /*who*/) {
  if (!command.wish)
    return {.result = refusal({ErrorCode::kInvalidArgument, "wish: expected START, STOP or KEEP"})};
  auto file = state_.recording.request(*command.wish);
  if (!file) return {.result = refusal(file.error())};
  return {.result = {.file = *std::move(file)}};
}

CommandExecutor::Outcome CommandExecutor::apply(const ControlReplay& command, const Requester& /*who*/) {
  return {.result = result_of(state_.replay.request(command.request))};
}

CommandExecutor::Outcome CommandExecutor::apply(const ControlCine& command, const Requester& /*who*/) {
  return {.result = result_of(state_.cine.request(command.request))};
}

CommandExecutor::Outcome CommandExecutor::apply(const ChangePresets& command, const Requester& who) {
  const Principal& principal = *who.identity.principal;
  const PresetStore::Author author{.name = principal.name,
                                   .is_admin = has_role(principal.role, kReplacesAdminsPresets)};
  const auto done =
      state_.presets.request(command.request, scene_message(state_.scene_store.in_force().scene), author);
  if (!done) return {.result = refusal(done.error())};
  return {.notice = Notice::kPresets};
}

CommandExecutor::Outcome CommandExecutor::apply(const ChangeMeasurements& command, const Requester& /*who*/) {
  const auto done = state_.measurements.request(command.request);
  if (!done) return {.result = refusal(done.error())};
  return {.notice = Notice::kMeasurements};
}

CommandExecutor::Outcome CommandExecutor::apply(const ControlRelay& command, const Requester& /*who*/) {
  Relay* const relay = state_.relay;
  if (relay == nullptr) {
    return {.result = refusal(
                {ErrorCode::kUnavailable, "the server was given no receiver, expected the option --rtp-to"})};
  }
  if (command.sends) {
    if (auto started = relay->start(); !started) return {.result = refusal(started.error())};
    return {.notice = Notice::kRelay};
  }
  if (!relay->sending()) {
    return {.result = refusal({ErrorCode::kUnavailable, "nothing is sent, so there is nothing to stop"})};
  }
  relay->stop();
  return {.notice = Notice::kRelay};
}

CommandExecutor::Outcome CommandExecutor::apply(const SendStill& /*command*/, const Requester& /*who*/) {
  if (state_.archive != nullptr) return {.audited = nullptr};  // what becomes of it is noted then
  return {.result = refusal({ErrorCode::kUnavailable,
                             "the server has no queue for an archive, expected the option --archive-queue"})};
}

Result<void> CommandExecutor::apply_to_lease(const ChangeControl& command, const SessionIdentity& who) {
  const auto done = [](const Result<bool>& held) { return held ? Result<void>() : held.error(); };
  switch (command.wish) {
    case v1::ControlRequest::ASK:
      return done(control_.ask(who.party(), now_ms()));
    case v1::ControlRequest::RELEASE:
      return done(control_.release(who.id, now_ms()));
    case v1::ControlRequest::GRANT:
      return done(control_.grant(who.id, command.to_session, now_ms()));
    case v1::ControlRequest::TAKE_OVER:
      control_.take_over(who.party(), now_ms());
      return {};
    case v1::ControlRequest::KEEP:
      return done(control_.keep(who.id, now_ms()));
    default:
      return Error{ErrorCode::kInvalidArgument, "wish: expected ASK, RELEASE, GRANT, TAKE_OVER or KEEP"};
  }
}

CommandExecutor::Outcome CommandExecutor::apply(const ChangeControl& command, const Requester& who) {
  const auto done = apply_to_lease(command, who.identity);
  if (!done) return {.result = refusal(done.error())};
  // Frequent, and changes nothing to report.
  if (command.wish == v1::ControlRequest::KEEP) return {.audited = nullptr};
  return {.notice = Notice::kControl};
}

// ---- answers that come later

void CommandExecutor::probe_changed() {
  thread_owner_.check();
  const ProbeStatus& status = state_.probe.status();
  while (!probe_changes_.empty() && probe_changes_.front().order <= status.order_answered) {
    const Pending pending = std::move(probe_changes_.front());
    probe_changes_.pop_front();
    const bool refused = !status.refusal.empty();
    Outcome outcome;
    if (refused) outcome.result = refusal({ErrorCode::kInvalidArgument, status.refusal});
    const bool freed = refused && pending.acquired_control && control_.holds(pending.who.identity.id) &&
                       control_.release(pending.who.identity.id, now_ms());
    finish(pending.who, pending.command, outcome, pending.answer, freed);
  }
}

/// nullopt: its session has ended.
std::optional<CommandExecutor::Pending> CommandExecutor::take_look(std::uint64_t asker) {
  const auto found = std::ranges::find(looks_, asker, &Pending::order);
  if (found == looks_.end()) return std::nullopt;
  Pending pending = std::move(*found);
  looks_.erase(found);
  return pending;
}

// These answers are neither counted nor audited: nothing was changed, and a volume without a surface or a
// point without fluid is no wrong request.

void CommandExecutor::survey_answered(const SurveyDesk::Answer& answer) {
  thread_owner_.check();
  const auto pending = take_look(answer.asker);
  if (!pending) return;
  if (answer.reply.has_refused())
    return pending->answer(refusal({ErrorCode::kUnavailable, answer.reply.refused().message()}));
  pending->answer({.found = answer.reply.found()});
}

void CommandExecutor::fluid_answered(const FluidDesk::Answer& answer) {
  thread_owner_.check();
  const auto pending = take_look(answer.asker);
  if (!pending) return;
  if (answer.reply.has_refused())
    return pending->answer(refusal({ErrorCode::kUnavailable, answer.reply.refused().message()}));
  pending->answer({.region = answer.reply.found()});
}

void CommandExecutor::forget(std::uint64_t session) {
  thread_owner_.check();
  const auto is_of_session = [session](const Pending& each) { return each.who.identity.id == session; };
  std::erase_if(probe_changes_, is_of_session);
  for (const Pending& each : looks_)
    if (is_of_session(each) && std::holds_alternative<MeasureFluid>(each.command))
      state_.fluid.forget(each.order);
  std::erase_if(looks_, is_of_session);
  if (control_.left(session, now_ms())) notify_(Notice::kControl, 0);
}

}  // namespace fanlight
