// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "proto/base/result.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/fanlight.pb.h"
#include "proto/model/scene.hpp"
#include "proto/model/volume.hpp"
#include "server/codec/encoder_pool.hpp"
#include "server/state/volume_copier.hpp"

namespace fanlight {

/// A scene that shows the surface of a volume.
struct FoundSurface {
  Scene scene;
  std::vector<std::string> choices;  ///< a sentence for each
  bool is_sure = true;               ///< false: slices beside it show more
};
/// Finds the surface. `scene`: what is not chosen stays as it is there. nullopt: none stands out, or a stop
/// was requested. Any thread; may take a second.
using SurfaceFinder = std::function<std::optional<FoundSurface>(const Volume& volume, const Scene& scene,
                                                                const std::stop_token& stop)>;

/// Finds the surface of the volume that is shown, for clients and for the server itself: on a thread of its
/// own, one survey at a time. A request that comes meanwhile waits for the next survey. Server thread only.
class SurveyDesk {
 public:
  /// Requests that wait for an answer.
  static constexpr std::size_t kMostRequests = 16;
  /// The asker of the server's own request.
  static constexpr std::uint64_t kServer = 0;

  enum class Outcome : std::uint8_t { kNoVolume, kNoMemory, kBusy, kNoSurface, kFound };
  /// The answer to one request.
  struct Answer {
    std::uint64_t asker = kServer;
    Outcome outcome = Outcome::kNoVolume;
    v1::SurveyReply reply;  ///< without a request id
  };
  /// All must outlive this object.
  struct Dependencies {
    SurfaceFinder find;  ///< empty: this server finds no surfaces
    VolumeCopier& volumes;
    Executor executor;
    std::function<Scene()> scene_in_force;
    std::function<void(const Answer& answer)> answered;
  };
  explicit SurveyDesk(Dependencies dependencies) : dependencies_(std::move(dependencies)) {}

  /// Answered later. `asker`: any number but kServer. The scene in force is where the survey starts. Error,
  /// kUnavailable: too many requests wait, or this server finds no surfaces.
  Result<void> request(std::uint64_t asker);

  /// The server's own request, with a scene of its own; answered later. False where a survey runs, the
  /// renderer has too many orders, or this server finds no surfaces.
  bool look(const Scene& scene);

  /// The survey that runs ends soon. Call it before the end of the executor's threads.
  void stop() { stop_.request_stop(); }

 private:
  struct Request {
    std::uint64_t asker = kServer;
    bool is_looked_for = false;  // by the survey that runs; else it waits for the next one
  };
  bool begin(const Scene& scene);
  void copied(VolumeCopier::Copy copy, const Scene& scene);
  void end(Outcome outcome, const FoundSurface& found);
  void answer_all(Outcome outcome, const FoundSurface& found);

  Dependencies dependencies_;
  std::vector<Request> requests_;
  bool looking_ = false;
  std::stop_source stop_;
  std::shared_ptr<Volume> copy_;  // its memory is used again while requests wait
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
