// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "proto/exchange/audience.hpp"
#include "proto/exchange/cine_link.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/frame_tap.hpp"
#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/private_view.hpp"
#include "proto/exchange/probe_link.hpp"
#include "proto/exchange/recording_link.hpp"
#include "proto/exchange/render_health.hpp"
#include "proto/exchange/replay_link.hpp"
#include "proto/exchange/survey.hpp"
#include "proto/exchange/volume_order.hpp"
#include "proto/model/picture.hpp"
#include "proto/model/pipeline_counters.hpp"
#include "proto/model/scene.hpp"

namespace fanlight {

/// The server thread's ends of all that it exchanges with the acquisition thread, the render thread and the
/// recorder. All must outlive the server.
struct PipelinePorts {
  Doorbell& bell;  ///< rung by the mailboxes that the server reads, and when the result of source_state changes
  Mailbox<Picture>& pictures;
  Mailbox<NumberedScene>& scenes;
  Mailbox<Error>& failures;  ///< of the render thread, which has then ended
  PipelineCounters counters;
  ProbeLink& probe;
  ReplayLink& replay;
  std::function<std::string()> source_state;              ///< "running", "ended", or why the source failed
  Mailbox<PrivateViews>* private_views = nullptr;         ///< null: private views are not available
  Mailbox<PrivateViewEnds>* private_view_ends = nullptr;  ///< null: the renderer ends none by itself
  Mailbox<RenderHealth>* render_health = nullptr;         ///< null: the renderer is always healthy
  Mailbox<SurveyOrder>* survey_orders = nullptr;          ///< null: the renderer finds no surfaces
  Mailbox<SurveyResult>* survey_results = nullptr;
  Mailbox<VolumeOrder>* volume_orders = nullptr;  ///< null: no volumes are sent
  Mailbox<VolumeAnswer>* volume_answers = nullptr;
  std::optional<RecordingLink> recording{};  ///< absent: nothing is recorded
  CineLink* cine = nullptr;                  ///< null: nothing is ever frozen
  Audience* audience = nullptr;              ///< null: every volume is rendered, even without clients
  FrameTap* frames = nullptr;                ///< of the source, for OpenIGTLink; null: none are sent
};

}  // namespace fanlight
