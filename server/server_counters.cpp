#include "server/server_counters.hpp"

namespace fanlight {

namespace {

void add_acquisition(std::vector<NamedCount>& to, const AcquisitionCounters& from) {
  const NamedCount counts[] = {
      {"frames_received", "Frames that came from the source", from.frames_received.value()},
      {"frames_assembled", "Frames in published volumes", from.frames_assembled.value()},
      {"frames_invalid", "Frames marked invalid or with an unusable angle", from.frames_invalid.value()},
      {"frames_damaged", "Frames whose checksum is wrong", from.frames_damaged.value()},
      {"frames_cut", "Frames that ended before their last pixel", from.frames_cut.value()},
      {"frames_misfit", "Frames of another size, format or geometry than the source's",
       from.frames_misfit.value()},
      {"frames_repeated", "Frames that had come before", from.frames_repeated.value()},
      {"frames_late", "Frames that came after their sweep was closed", from.frames_late.value()},
      {"frames_over_capacity", "Frames of sweeps longer than a volume can hold",
       from.frames_over_capacity.value()},
      {"frames_in_short_volumes", "Frames of sweeps whose angle did not move",
       from.frames_in_short_volumes.value()},
      {"frames_in_incomplete_volumes", "Frames of sweeps of which too much is missing",
       from.frames_in_incomplete_volumes.value()},
      {"frames_abandoned", "Frames of the sweep under way when the source stopped or was lost",
       from.frames_abandoned.value()},
      {"frames_pending", "Frames of the sweep being filled", from.frames_pending.value(),
       NamedCount::Kind::kNow},
      {"frames_missing", "Gaps in the frames' sequence", from.frames_missing.value()},
      {"frames_reordered", "Frames that came after a later one and were used", from.frames_reordered.value()},
      {"sequence_restarts", "Times the frames' sequence began anew without a word",
       from.sequence_restarts.value()},
      {"volumes_short", "Sweeps dropped because their angle did not move", from.volumes_short.value()},
      {"volumes_incomplete", "Sweeps dropped because too much of them is missing",
       from.volumes_incomplete.value()},
      {"volumes_interpolated", "Volumes with missing frames that their neighbours stand in for",
       from.volumes_interpolated.value()},
      {"geometry_changes", "Changes of the frames' geometry in mid-stream", from.geometry_changes.value()},
      {"mismatch_estimates", "Pairs of sweeps compared for the mismatch of to and fro",
       from.mismatch_estimates.value()},
      {"mismatch_refusals", "Pairs of sweeps with too little in them to compare",
       from.mismatch_refusals.value()},
  };
  to.insert(to.end(), std::begin(counts), std::end(counts));
}

void add_probe(std::vector<NamedCount>& to, const ProbeCounters& from) {
  const NamedCount counts[] = {
      {"probe_bytes_received", "Bytes that came over USB", from.bytes_received.value()},
      {"probe_bytes_skipped", "Bytes between frames that are no frame", from.bytes_skipped.value()},
      {"probe_transfers_completed", "Transfers that ended well", from.transfers_completed.value()},
      {"probe_transfers_short", "Transfers that ended in the midst of a frame", from.transfers_short.value()},
      {"probe_transfers_stalled", "Halts of the probe's pipe", from.transfers_stalled.value()},
      {"probe_transfers_timed_out", "Silences of the probe", from.transfers_timed_out.value()},
      {"probe_transfers_overflowed", "Transfers with more than was asked for",
       from.transfers_overflowed.value()},
      {"probe_transfers_failed", "Transfers with another error on the bus", from.transfers_failed.value()},
      {"probe_transfers_refused", "Transfers that the system did not take", from.transfers_refused.value()},
      {"probe_streams_restarted", "Times the probe was stopped and started again",
       from.streams_restarted.value()},
      {"probe_requests_failed", "Requests that the probe did not answer", from.requests_failed.value()},
      {"probes_found", "Times a probe was taken", from.probes_found.value()},
      {"probes_lost", "Times a probe was lost", from.probes_lost.value()},
      {"probe_settings_taken", "Settings that the probe took", from.settings_taken.value()},
      {"probe_settings_refused", "Settings that the probe did not take", from.settings_refused.value()},
  };
  to.insert(to.end(), std::begin(counts), std::end(counts));
}

void add_volumes_and_pictures(std::vector<NamedCount>& to, const RingCounters& ring, const FeedCounters& feed,
                              const RenderCounters& render) {
  const NamedCount counts[] = {
      {"frames_fed", "Frames handed to the renderer ahead of their volume", feed.frames_fed.value()},
      {"frames_not_fed", "Frames that found no room on that way, and came with their volume alone",
       feed.frames_not_fed.value()},
      {"volumes_published", "Volumes put into the ring", ring.volumes_published.value()},
      {"volumes_taken", "Volumes that the renderer took", ring.volumes_taken.value()},
      {"volumes_dropped", "Volumes replaced unread by a newer one", ring.volumes_dropped.value()},
      {"volumes_rendered", "Volumes of which a picture was finished", render.volumes_rendered.value()},
      {"volumes_skipped", "Volumes given up for a newer one before they had a picture",
       render.volumes_skipped.value()},
      {"volumes_refused", "Volumes too large for this GPU", render.volumes_refused.value()},
      {"volumes_unfiltered", "Volumes too large for the speckle filter on this GPU, cast without it",
       render.volumes_unfiltered.value()},
      {"pass1_runs", "Ray casts", render.pass1_runs.value()},
      {"pass2_runs", "Runs of filter, light and finish", render.pass2_runs.value()},
      {"pictures_finished", "Pictures rendered", render.pictures_finished.value()},
      {"pictures_outdated", "Pictures done after one of a newer volume", render.pictures_outdated.value()},
      {"pictures_replaced", "Pictures replaced before the server read them",
       render.pictures_replaced.value()},
      {"private_casts", "Ray casts of private views", render.private_casts.value()},
      {"private_casts_given_up", "Of those, given up since the main view took their frames",
       render.private_casts_given_up.value()},
      {"private_pictures", "Pictures of private views", render.private_pictures.value()},
      {"private_views_refused", "Private views that this GPU had no memory for",
       render.private_views_refused.value()},
  };
  to.insert(to.end(), std::begin(counts), std::end(counts));
}

void add_server(std::vector<NamedCount>& to, const ServerCounters& from) {
  const NamedCount counts[] = {
      {"pictures_encoded", "Pictures encoded", from.pictures_encoded.value()},
      {"pictures_offered", "Pictures offered to sessions", from.pictures_offered.value()},
      {"pictures_sent", "Pictures sent to sessions", from.pictures_sent.value()},
      {"pictures_skipped", "Pictures that a session was too slow for", from.pictures_skipped.value()},
      {"sessions_opened", "Displays that connected", from.sessions_opened.value()},
      {"sessions_closed", "Displays that left", from.sessions_closed.value()},
      {"connections_refused", "Connections beyond the limit", from.connections_refused.value()},
      {"handshakes_failed", "TLS handshakes that came to nothing", from.handshakes_failed.value()},
      {"encodings_failed", "Displays closed since their picture could not be encoded",
       from.encodings_failed.value()},
      {"sessions_stalled", "Displays dropped since they took nothing for five seconds",
       from.sessions_stalled.value()},
      {"audit_lines_lost", "Lines of the audit log that the disk had no room for",
       from.audit_lines_lost.value()},
      {"control_refusals", "Wishes to be in control that were not granted", from.control_refusals.value()},
      {"requests_refused", "HTTP requests that were refused", from.requests_refused.value()},
      {"messages_refused", "WebSocket messages that were refused", from.messages_refused.value()},
      {"scene_changes", "Scene changes taken", from.scene_changes.value()},
      {"scene_refusals", "Scene changes refused", from.scene_refusals.value()},
      {"private_views", "Private views that are open", from.private_views.value()},
      {"private_view_refusals", "Changes of private views that were refused",
       from.private_view_refusals.value()},
      {"private_views_ended", "Private views ended since the main view left them no time for five seconds",
       from.private_views_ended.value()},
      {"probe_changes", "Changes of the probe that displays asked for and got", from.probe_changes.value()},
      {"probe_refusals", "Changes of the probe that were refused", from.probe_refusals.value()},
  };
  to.insert(to.end(), std::begin(counts), std::end(counts));
}

}  // namespace

std::vector<NamedCount> named_counts(const HouseCounters& house, const ServerCounters& server) {
  std::vector<NamedCount> counts;
  house.acquisition.ledger.read([&] {
    counts.clear();
    add_acquisition(counts, house.acquisition);
  });
  add_probe(counts, house.probe);
  add_volumes_and_pictures(counts, house.ring, house.feed, house.render);
  add_server(counts, server);
  return counts;
}

std::vector<NamedValue> named_values(const HouseCounters& house) {
  const AcquisitionCounters& acquisition = house.acquisition;
  return {
      {"sweep_mismatch_degrees", "Mismatch of forward and backward sweeps that is corrected",
       acquisition.mismatch_deg.value()},
      {"sweep_mismatch_left_degrees", "What is left of it", acquisition.mismatch_left_deg.value()},
      {"sweep_mismatch_left_millimetres", "What is left of it at half the depth",
       acquisition.mismatch_left_mm.value()},
  };
}

}  // namespace fanlight
