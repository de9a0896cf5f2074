// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "server/access/audit_log.hpp"
#include "server/access/control_lease.hpp"
#include "server/access/role.hpp"
#include "server/http/api_response.hpp"
#include "server/http/rtp_api.hpp"
#include "server/metrics/server_counters.hpp"
#include "server/state/cine_proxy.hpp"
#include "server/state/picture_demand.hpp"
#include "server/state/preset_store.hpp"
#include "server/state/recording_proxy.hpp"
#include "server/state/replay_proxy.hpp"
#include "server/state/scene_store.hpp"
#include "server/stream/picture_hub.hpp"
#include "server/stream/session_registry.hpp"

namespace fanlight {

/// Requests of scripts over plain HTTP, with the rights that the same principal has in a session:
///
///   GET   /api/scene         the scene in force, as JSON
///   PATCH /api/scene         changes some of its fields: {"light": {"up_mm": 20}}
///   GET   /api/picture.png   the newest picture of the main view
///   GET   /api/presets       the presets that were saved, as JSON
///   POST  /api/presets       {"save": "my face"}, with or without "scene": {...}; or {"remove": "my face"}
///   GET   /api/recording     the state of the recorder, as JSON
///   POST  /api/recording     {"wish": "start"}, "stop" or "keep": the name of the file
///   GET   /api/replay        the state of the player of a recording, as JSON
///   POST  /api/replay        {"wish": "pause"}, "play", "step=-1", "seek=3.5", ...: see replay_request()
///   GET   /api/cine          which of the last volumes is on show, as JSON
///   POST  /api/cine          {"wish": "freeze"}, "live", "play", "step=-1", ...: see cine_request()
///   /api/rtp                 the stream that leaves the room: see RtpApi
///
/// Server thread only.
class RestApi {
 public:
  using Request = ApiRequest;
  using Response = ApiResponse;

  /// All must outlive this object.
  struct Dependencies {
    ServerCounters& counters;
    SceneStore& scene_store;
    PictureHub& hub;
    const ControlLease& control;
    AuditLog& audit;
    SessionRegistry& sessions;
    RecordingProxy& recording;
    ReplayProxy& replay;
    CineProxy& cine;
    PresetStore& presets;
    PictureDemand& demand;
    RtpApi& rtp;
  };
  explicit RestApi(const Dependencies& dependencies) : dependencies_(dependencies) {}

  /// `path`: of the request, from "/api/" on, without the query.
  Response respond(const Request& request, std::string_view path, const Principal& principal);

  /// The answer to a GET of /api/picture.png, once the picture is encoded. Where nothing was rendered, since
  /// nobody looked, a picture is rendered first: within kMostWaitNs, or the answer is a refusal.
  void picture(const Principal& principal, const std::function<void(Response)>& answer, std::int64_t now_ns);
  static constexpr std::int64_t kMostWaitNs = 5'000'000'000;

  /// Answers those who wait for a picture, where there is one now, or where they have waited long enough.
  /// Call it after every picture, and once a second.
  void answer_waiting(std::int64_t now_ns);
  /// Lets those who wait go without an answer: the server ends.
  void abandon() { waiting_.clear(); }

 private:
  Response scene() const;
  Response recording() const;
  Response record(const Request& request, const Principal& principal);
  Response replay() const;
  Response control_replay(const Request& request, const Principal& principal);
  Response presets() const;
  Response change_presets(const Request& request, const Principal& principal);
  Response cine() const;
  Response control_cine(const Request& request, const Principal& principal);
  /// The name of a kind of wishes in the audit log, and where refused ones are counted.
  struct WishKind {
    const char* name;
    Counter& refusals;
  };
  template <typename Proxy, typename Wish>
  Response carry_out(const WishKind& kind, const Result<Wish>& wish, Proxy& proxy, const std::string& words,
                     const Principal& principal);
  Response change_scene(const Request& request, const Principal& principal);
  void audit_change(const Principal& principal, const std::string& result,
                    const nlohmann::json& details) const;

  struct Waiting {
    Principal principal;
    std::function<void(Response)> answer;
    std::int64_t until_ns = 0;
  };
  void encode_picture(const Principal& principal, const std::function<void(Response)>& answer);

  Dependencies dependencies_;
  std::vector<Waiting> waiting_;
};

}  // namespace fanlight
