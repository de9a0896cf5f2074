// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "proto/base/result.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/scene.hpp"
#include "server/access/audit_log.hpp"
#include "server/access/session_identity.hpp"
#include "server/command/session_audit.hpp"
#include "server/state/fluid_desk.hpp"
#include "server/state/recording_proxy.hpp"

namespace fanlight {

// What clients may ask for, through any protocol. Settings of a client's own stream are no commands: they
// concern its connection alone.

/// Changes fields of the scene of the main view.
struct ChangeScene {
  v1::Scene fields;
};
/// Changes fields of the session's private view, and opens it if there is none.
struct ChangeView {
  v1::Scene fields;
};
/// Ends the session's private view.
struct LeaveView {};
/// Changes settings of the probe. Answered when the probe has answered.
struct ChangeProbe {
  v1::ProbeSettings settings;
};
/// Finds the surface in the newest volume. Answered when the renderer has looked.
struct FindSurface {};
/// Measures the fluid at a point of the volume on show. Answered when that is done.
struct MeasureFluid {
  FluidQuestion question;
};
struct ControlRecorder {
  std::optional<RecordingWish> wish;  ///< absent: one that this version does not know
};
struct ControlReplay {
  v1::ReplayRequest request;
};
struct ControlCine {
  v1::CineRequest request;
};
/// Saves or removes a preset.
struct ChangePresets {
  v1::PresetRequest request;
};
/// Keeps a measurement, or renames or removes one.
struct ChangeMeasurements {
  v1::MeasurementRequest request;
};
/// Starts or stops the pictures to the RTP receiver.
struct ControlRelay {
  bool sends = false;
};
/// Puts a still, a clip or a volume into the queue for an archive. The picture is not part of the command:
/// who gives it writes it once the command is accepted.
struct SendStill {};
/// Asks for control, releases it, grants it, takes it over or keeps it.
struct ChangeControl {
  v1::ControlRequest::Wish wish = v1::ControlRequest::ASK;
  std::uint64_t to_session = 0;  ///< GRANT: to whom
};

using ClientCommand = std::variant<ChangeScene, ChangeView, LeaveView, ChangeProbe, FindSurface, MeasureFluid,
                                   ControlRecorder, ControlReplay, ControlCine, ChangePresets,
                                   ChangeMeasurements, ControlRelay, SendStill, ChangeControl>;

/// Who asks. Both must outlive the answer, or CommandExecutor::forget().
struct Requester {
  const SessionIdentity& identity;  ///< authenticated
  SessionAudit& audit;
};

/// A client without a session: one request of a script, or of an OpenIGTLink client.
class SessionlessRequester {
 public:
  SessionlessRequester(AuditLog& log, const Principal& principal)
      : identity_{.id = 0, .address = principal.address, .principal = principal, .name = principal.name},
        audit_(log, identity_) {}
  SessionlessRequester(const SessionlessRequester&) = delete;
  SessionlessRequester& operator=(const SessionlessRequester&) = delete;

  Requester requester() { return {.identity = identity_, .audit = audit_}; }

 private:
  SessionIdentity identity_;
  SessionAudit audit_;
};

/// The answer to a command.
struct CommandResult {
  enum class Refused : std::uint8_t {
    kNot,
    kByRole,     ///< the role may not
    kByControl,  ///< another session holds control
    kByAudit,    ///< the audit log is required and cannot be written
    kByCommand,  ///< a value is out of range, or the state does not allow it
  };
  Refused refused = Refused::kNot;
  Error error{};                      ///< where it was refused
  const SceneField* field = nullptr;  ///< the field of the scene that was refused, if one was
  bool view_ended = false;            ///< LeaveView: there was a view
  std::string file{};                 ///< ControlRecorder: the recording's name
  v1::SurveyFound found{};            ///< FindSurface: the scene that shows the surface
  v1::FluidRegion region{};           ///< MeasureFluid

  explicit operator bool() const { return refused == Refused::kNot; }
};

}  // namespace fanlight
