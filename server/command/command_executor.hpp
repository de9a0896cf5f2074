// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "proto/base/thread_owner.hpp"
#include "server/access/control_lease.hpp"
#include "server/command/command.hpp"
#include "server/command/command_rules.hpp"
#include "server/state/notice.hpp"
#include "server/state/server_state.hpp"

namespace fanlight {

/// The one way in which clients change anything, whatever protocol they speak: checks role and control,
/// applies the command, counts and audits it, answers, and notifies the other sessions, in this order. Server
/// thread only.
class CommandExecutor {
 public:
  /// Called once with the answer, before other sessions are notified.
  using Answer = std::function<void(const CommandResult& result)>;
  /// Notifies all sessions but one; 0: no exception.
  using Notify = std::function<void(Notice notice, std::uint64_t except_session)>;

  /// Answers of a session that wait for the probe.
  static constexpr std::size_t kMostPendingProbeChanges = 16;

  /// All must outlive this object.
  CommandExecutor(ServerState& state, ControlLease& control, Notify notify)
      : state_(state), control_(control), notify_(std::move(notify)) {}

  /// Carries out a command. `answer` is called before this returns, but for ChangeProbe, FindSurface and
  /// MeasureFluid that were not refused at once: then by probe_changed(), survey_answered() or
  /// fluid_answered(), unless the session is forgotten before.
  void execute(const Requester& who, const ClientCommand& command, const Answer& answer);

  /// Refuses a request that could not be read as a command: counts and audits it. `kind`: what it tried to
  /// be. The result is refused by role or control where the command itself would be; else it has `error`.
  /// `details`: for the audit log.
  CommandResult reject(const Requester& who, const ClientCommand& kind, const Error& error,
                       const nlohmann::json& details = nullptr);

  /// The state of the probe has changed: answers those whose orders it has answered. Call it before
  /// Notice::kProbe.
  void probe_changed();
  /// The renderer has looked for the surface, for an asker other than the server.
  void survey_answered(const SurveyDesk::Answer& answer);
  /// Fluid was measured.
  void fluid_answered(const FluidDesk::Answer& answer);

  /// The session ends: its answers are not wanted any more, and control is free.
  void forget(std::uint64_t session);

 private:
  /// What a command has done, in addition to its result.
  struct Outcome {
    CommandResult result;
    const char* audited = "done";  ///< result in the audit log, where it was not refused; null: no line
    std::optional<Notice> notice{};
    std::uint64_t waits_for = 0;  ///< number of an order; the answer comes later
  };
  /// An answer that waits.
  struct Pending {
    std::uint64_t order;  ///< of the probe, or the asker of a survey or of a measurement
    Requester who;
    ClientCommand command;
    Answer answer;
    bool acquired_control;  ///< the session did not hold it before
  };

  CommandResult permission(const CommandRule& rule, const Requester& who) const;
  Outcome apply(const ChangeScene& change, const Requester& who);
  Outcome apply(const ChangeView& change, const Requester& who);
  Outcome apply(const LeaveView& change, const Requester& who);
  Outcome apply(const ChangeProbe& change, const Requester& who);
  Outcome apply(const FindSurface& command, const Requester& who);
  Outcome apply(const MeasureFluid& command, const Requester& who);
  Outcome apply(const ControlRecorder& command, const Requester& who);
  Outcome apply(const ControlReplay& command, const Requester& who);
  Outcome apply(const ControlCine& command, const Requester& who);
  Outcome apply(const ChangePresets& command, const Requester& who);
  Outcome apply(const ChangeMeasurements& command, const Requester& who);
  Outcome apply(const ControlRelay& command, const Requester& who);
  Outcome apply(const SendStill& command, const Requester& who);
  Outcome apply(const ChangeControl& command, const Requester& who);
  Result<void> apply_to_lease(const ChangeControl& command, const SessionIdentity& who);
  nlohmann::json details(const ClientCommand& command, const CommandResult& result) const;
  void note(const Requester& who, const ClientCommand& command, const Outcome& outcome) const;
  void finish(const Requester& who, const ClientCommand& command, const Outcome& outcome,
              const Answer& answer, bool control_changed);
  bool acquire(const CommandRule& rule, const SessionIdentity& who);
  std::optional<Pending> take_look(std::uint64_t asker);

  ServerState& state_;
  ControlLease& control_;
  Notify notify_;
  std::list<Pending> probe_changes_;  // in the order of their numbers
  std::list<Pending> looks_;          // surveys and measurements
  std::uint64_t last_asker_ = SurveyDesk::kServer;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
