#include "server/server_counters.hpp"

namespace fanlight {

std::vector<NamedCount> named_counts(const HouseCounters& house, const ServerCounters& server) {
  return {
      {"frames_received", "Frames that came from the source", house.acquisition.frames_received.value()},
      {"frames_missing", "Gaps in the frames' sequence", house.acquisition.frames_missing.value()},
      {"frames_assembled", "Frames in published volumes", house.acquisition.frames_assembled.value()},
      {"frames_invalid", "Frames marked invalid or with an unusable angle",
       house.acquisition.frames_invalid.value()},
      {"frames_over_capacity", "Frames of sweeps longer than a volume can hold",
       house.acquisition.frames_over_capacity.value()},
      {"frames_in_short_volumes", "Frames of sweeps whose angle did not move",
       house.acquisition.frames_in_short_volumes.value()},
      {"frames_abandoned", "Frames of the sweep under way when the source was stopped",
       house.acquisition.frames_abandoned.value()},
      {"volumes_short", "Sweeps dropped because their angle did not move",
       house.acquisition.volumes_short.value()},
      {"volumes_published", "Volumes put into the ring", house.ring.volumes_published.value()},
      {"volumes_taken", "Volumes that the renderer took", house.ring.volumes_taken.value()},
      {"volumes_dropped", "Volumes replaced unread by a newer one", house.ring.volumes_dropped.value()},
      {"pass1_runs", "Ray casts", house.render.pass1_runs.value()},
      {"pass2_runs", "Runs of filter, light and finish", house.render.pass2_runs.value()},
      {"volumes_unfiltered", "Volumes too large for the speckle filter on this GPU, cast without it",
       house.render.volumes_unfiltered.value()},
      {"pictures_finished", "Pictures rendered", house.render.pictures_finished.value()},
      {"pictures_outdated", "Pictures done after one of a newer volume",
       house.render.pictures_outdated.value()},
      {"pictures_replaced", "Pictures replaced before the server read them",
       house.render.pictures_replaced.value()},
      {"pictures_encoded", "Pictures encoded", server.pictures_encoded.value()},
      {"pictures_offered", "Pictures offered to sessions", server.pictures_offered.value()},
      {"pictures_sent", "Pictures sent to sessions", server.pictures_sent.value()},
      {"pictures_skipped", "Pictures that a session was too slow for", server.pictures_skipped.value()},
      {"sessions_opened", "Displays that connected", server.sessions_opened.value()},
      {"sessions_closed", "Displays that left", server.sessions_closed.value()},
      {"connections_refused", "Connections beyond the limit", server.connections_refused.value()},
      {"requests_refused", "HTTP requests that were refused", server.requests_refused.value()},
      {"messages_refused", "WebSocket messages that were refused", server.messages_refused.value()},
      {"scene_changes", "Scene changes taken", server.scene_changes.value()},
      {"scene_refusals", "Scene changes refused", server.scene_refusals.value()},
  };
}

}  // namespace fanlight
