// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/base/counter.hpp"
#include "proto/base/counter_table.hpp"
#include "proto/model/pipeline_counters.hpp"

namespace fanlight {

/// Written by the server thread. Over all sessions,
///   pictures_offered = pictures_sent + pictures_skipped + those that wait or are being sent.
struct ServerCounters {
  Counter pictures_encoded;
  Counter pictures_offered;
  Counter pictures_sent;
  Counter picture_bytes_sent;
  Counter pictures_skipped;  ///< replaced unsent by a newer one, or unsent when the session ended
  Counter sessions_opened;
  Counter sessions_closed;
  Counter connections_refused;               ///< beyond the limit
  Gauge<std::uint64_t> connections_evicted;  ///< of anonymous clients: others needed their place
  Counter handshakes_failed;                 ///< of TLS
  Counter logins_refused;                    ///< with a token or certificate that does not open Fanlight
  Gauge<std::uint64_t> certificate_expires_timestamp_seconds;  ///< since 1970; 0 without TLS
  Counter encodings_failed;               ///< sessions closed because their picture could not be encoded
  Counter sessions_out_of_memory;         ///< closed because there was no memory for what they asked for
  Counter handlers_out_of_memory;         ///< ended by a lack of memory; most of them of connections
  Counter sessions_unanswered;            ///< closed because they answered no ping for ten seconds
  Counter sessions_stalled;               ///< closed because they acknowledged nothing for five seconds
  Gauge<std::uint64_t> audit_lines_lost;  ///< for which the disk had no room
  Counter control_refusals;               ///< requests for control that were not granted
  Counter requests_refused;  ///< HTTP requests that were malformed, too long or for no known path
  Counter messages_refused;  ///< malformed, oversized or unexpected WebSocket messages
  Counter scene_changes;
  Counter scene_refusals;              ///< changes with a value that is not allowed
  Counter scene_changes_overdue;       ///< that no picture showed after two seconds
  Counter scene_changes_withdrawn;     ///< since the GPU could not draw them
  Gauge<std::uint64_t> private_views;  ///< open now
  Counter private_view_refusals;
  Counter private_views_ended;   ///< because the main view had left them no time for five seconds
  Counter recording_refusals;    ///< wishes of the recorder that were not granted
  Counter replay_refusals;       ///< wishes of the player of a recording that were not granted
  Counter preset_refusals;       ///< presets that were not saved or removed as was asked for
  Counter cine_refusals;         ///< wishes to freeze, or about the last volumes, that were not granted
  Counter survey_refusals;       ///< requests to find the surface that were refused
  Counter fluid_refusals;        ///< requests to measure fluid that were refused
  Counter measurement_refusals;  ///< measurements that were not kept, renamed or removed as was asked for
  Counter probe_changes;
  Counter probe_refusals;  ///< changes of the probe that are not allowed, or that it did not accept

  // Of OpenIGTLink clients:
  //   igtl_messages_offered = igtl_messages_sent + igtl_messages_skipped + those that wait or are being sent.
  Counter igtl_clients_opened;
  Counter igtl_clients_closed;
  Counter igtl_clients_stalled;    ///< closed because they acknowledged nothing for five seconds
  Counter igtl_clients_timed_out;  ///< closed because a head did not come in time, or they were idle
  Counter igtl_clients_evicted;    ///< closed because another client needed their place
  Counter igtl_clients_refused;    ///< all places were taken
  Counter igtl_messages_offered;   ///< of streams; answers are not counted
  Counter igtl_messages_sent;
  Counter igtl_bytes_sent;        ///< of those
  Counter igtl_messages_skipped;  ///< replaced unsent by a newer one, or unsent when the client left
  Counter igtl_messages_refused;  ///< that came damaged, or were no OpenIGTLink
  Counter igtl_messages_ignored;  ///< that came and are of no use here
  Gauge<std::uint64_t>
      igtl_frames_missed;         ///< of the source, before they were written: the server was too slow
  Counter igtl_command_refusals;  ///< commands that were not carried out

  // Of the stream by RTP:
  Counter rtp_pictures_sent;  ///< whole
  Counter rtp_pictures_cut;   ///< of which the system did not take all packets
  Counter rtp_packets_sent;
  Counter rtp_bytes_sent;      ///< of those, with their headers
  Counter rtp_send_failures;   ///< packets that the system did not take
  Counter rtp_keys_requested;  ///< by the receiver
  Counter rtp_reports_received;
  Counter rtp_packets_not_resent;  ///< that the receiver asked for again
  Counter rtp_feedback_refused;    ///< what came to it and is no RTCP
  Counter rtp_refusals;            ///< wishes to start or stop it that were not granted

  // Of the queue for an archive:
  Counter archive_stills;                   ///< put in
  Counter archive_volumes;                  ///< put in
  Counter archive_failures;                 ///< those that were not put in
  Counter archive_refusals;                 ///< of those, and other requests, that were not granted
  Gauge<std::uint64_t> archive_waiting;     ///< objects that the archive does not have yet
  Gauge<std::uint64_t> archive_rejections;  ///< objects that the archive has refused
};

inline constexpr auto kServerTable = std::to_array<CountRow<ServerCounters>>({
    {"pictures_encoded", "Pictures encoded", &ServerCounters::pictures_encoded},
    {"pictures_offered", "Pictures offered to sessions", &ServerCounters::pictures_offered},
    {"pictures_sent", "Pictures sent to sessions", &ServerCounters::pictures_sent},
    {"picture_bytes_sent", "Bytes of the pictures sent", &ServerCounters::picture_bytes_sent},
    {"pictures_skipped", "Pictures skipped because a session was too slow",
     &ServerCounters::pictures_skipped},
    {"sessions_opened", "Displays that connected", &ServerCounters::sessions_opened},
    {"sessions_closed", "Displays that disconnected", &ServerCounters::sessions_closed},
    {"connections_refused", "Connections beyond the limit", &ServerCounters::connections_refused},
    {"connections_evicted", "Connections without credentials closed to make room for others",
     &ServerCounters::connections_evicted},
    {"handshakes_failed", "TLS handshakes that failed", &ServerCounters::handshakes_failed},
    {"logins_refused", "Logins with a token or certificate that is unknown, revoked or expired",
     &ServerCounters::logins_refused},
    {"certificate_expires_timestamp_seconds", "When the certificate expires, since 1970; 0 without TLS",
     &ServerCounters::certificate_expires_timestamp_seconds, CountKind::kNow},
    {"encodings_failed", "Displays closed because their picture could not be encoded",
     &ServerCounters::encodings_failed},
    {"sessions_out_of_memory", "Displays dropped because there was no memory for their requests",
     &ServerCounters::sessions_out_of_memory},
    {"handlers_out_of_memory", "Operations of the server abandoned because there was no memory",
     &ServerCounters::handlers_out_of_memory},
    {"sessions_unanswered", "Displays dropped because they answered no ping for ten seconds",
     &ServerCounters::sessions_unanswered},
    {"sessions_stalled", "Displays dropped because they read nothing for five seconds",
     &ServerCounters::sessions_stalled},
    {"audit_lines_lost", "Lines of the audit log that could not be written",
     &ServerCounters::audit_lines_lost},
    {"control_refusals", "Requests for control that were refused", &ServerCounters::control_refusals},
    {"requests_refused", "HTTP requests that were refused", &ServerCounters::requests_refused},
    {"messages_refused", "WebSocket messages that were refused", &ServerCounters::messages_refused},
    {"scene_changes", "Scene changes accepted", &ServerCounters::scene_changes},
    {"scene_refusals", "Scene changes refused", &ServerCounters::scene_refusals},
    {"scene_changes_overdue", "Scene changes that no picture showed after two seconds",
     &ServerCounters::scene_changes_overdue},
    {"scene_changes_withdrawn", "Scene changes withdrawn because the GPU could not draw them",
     &ServerCounters::scene_changes_withdrawn},
    {"private_views", "Private views that are open", &ServerCounters::private_views, CountKind::kNow},
    {"private_view_refusals", "Changes of private views that were refused",
     &ServerCounters::private_view_refusals},
    {"private_views_ended", "Private views ended because the main view left them no time for five seconds",
     &ServerCounters::private_views_ended},
    {"recording_refusals", "Requests to start, stop or keep a recording that were refused",
     &ServerCounters::recording_refusals},
    {"replay_refusals", "Playback requests that were refused", &ServerCounters::replay_refusals},
    {"preset_refusals", "Requests to save or remove a preset that were refused",
     &ServerCounters::preset_refusals},
    {"cine_refusals", "Cine requests that were refused", &ServerCounters::cine_refusals},
    {"survey_refusals", "Requests to find the surface that were refused", &ServerCounters::survey_refusals},
    {"fluid_refusals", "Requests to measure fluid that were refused", &ServerCounters::fluid_refusals},
    {"measurement_refusals", "Requests to keep, rename or remove a measurement that were refused",
     &ServerCounters::measurement_refusals},
    {"probe_changes", "Probe settings changed by displays", &ServerCounters::probe_changes},
    {"probe_refusals", "Changes of the probe that were refused", &ServerCounters::probe_refusals},
    {"igtl_clients_opened", "OpenIGTLink clients that connected", &ServerCounters::igtl_clients_opened},
    {"igtl_clients_closed", "OpenIGTLink clients that disconnected", &ServerCounters::igtl_clients_closed},
    {"igtl_clients_stalled", "OpenIGTLink clients dropped because they read nothing for five seconds",
     &ServerCounters::igtl_clients_stalled},
    {"igtl_clients_timed_out",
     "OpenIGTLink clients dropped because they sent no whole head in time, or were idle",
     &ServerCounters::igtl_clients_timed_out},
    {"igtl_clients_evicted",
     "OpenIGTLink clients that sent no message and gave their place to another client",
     &ServerCounters::igtl_clients_evicted},
    {"igtl_clients_refused", "OpenIGTLink clients refused because all places were taken",
     &ServerCounters::igtl_clients_refused},
    {"igtl_messages_offered",
     "OpenIGTLink messages of pictures, volumes, poses and frames offered to clients",
     &ServerCounters::igtl_messages_offered},
    {"igtl_messages_sent", "OpenIGTLink messages sent", &ServerCounters::igtl_messages_sent},
    {"igtl_bytes_sent", "Bytes of the OpenIGTLink messages sent", &ServerCounters::igtl_bytes_sent},
    {"igtl_messages_skipped", "OpenIGTLink messages replaced by newer ones because their client was too slow",
     &ServerCounters::igtl_messages_skipped},
    {"igtl_messages_refused", "Messages from OpenIGTLink clients that were damaged or not OpenIGTLink",
     &ServerCounters::igtl_messages_refused},
    {"igtl_messages_ignored", "Messages from OpenIGTLink clients that are not used",
     &ServerCounters::igtl_messages_ignored},
    {"igtl_frames_missed", "Frames that the server was too slow to send to any OpenIGTLink client",
     &ServerCounters::igtl_frames_missed},
    {"igtl_command_refusals", "Commands from OpenIGTLink clients that were refused",
     &ServerCounters::igtl_command_refusals},
    {"rtp_pictures_sent", "Pictures sent completely by RTP", &ServerCounters::rtp_pictures_sent},
    {"rtp_pictures_cut", "Pictures with RTP packets that the system refused",
     &ServerCounters::rtp_pictures_cut},
    {"rtp_packets_sent", "RTP packets sent", &ServerCounters::rtp_packets_sent},
    {"rtp_bytes_sent", "Bytes of the RTP packets sent", &ServerCounters::rtp_bytes_sent},
    {"rtp_send_failures", "RTP and RTCP packets that the system refused", &ServerCounters::rtp_send_failures},
    {"rtp_keys_requested", "Key frames requested by the receiver of the RTP stream",
     &ServerCounters::rtp_keys_requested},
    {"rtp_reports_received", "Reports from the receiver of the RTP stream",
     &ServerCounters::rtp_reports_received},
    {"rtp_packets_not_resent", "RTP packets that the receiver requested again; none is sent twice",
     &ServerCounters::rtp_packets_not_resent},
    {"rtp_feedback_refused", "Packets received on the RTP stream that are not RTCP",
     &ServerCounters::rtp_feedback_refused},
    {"rtp_refusals", "Requests to start or stop the RTP stream that were refused",
     &ServerCounters::rtp_refusals},
    {"archive_stills", "Stills and clips put into the queue for the archive",
     &ServerCounters::archive_stills},
    {"archive_volumes", "Volumes put into the queue for the archive", &ServerCounters::archive_volumes},
    {"archive_failures", "Stills, clips and volumes that could not be put into the queue for the archive",
     &ServerCounters::archive_failures},
    {"archive_refusals", "Requests to send a still, a clip or a volume to the archive that were refused",
     &ServerCounters::archive_refusals},
    {"archive_waiting", "Objects in the queue that the archive does not have yet",
     &ServerCounters::archive_waiting, CountKind::kNow},
    {"archive_rejections", "Objects in the queue that the archive has refused",
     &ServerCounters::archive_rejections, CountKind::kNow},
});

// Every counter has a row in the table.
static_assert(sizeof(ServerCounters) == kServerTable.size() * sizeof(Counter));

/// A count with its metric, see CountRow.
struct NamedCount {
  const char* name;
  const char* help;
  std::uint64_t value;
  CountKind kind;
};

/// A value with its metric, see ValueRow.
struct NamedValue {
  const char* name;
  const char* help;
  double value;
};
std::vector<NamedValue> named_values(const PipelineCounters& pipeline);

/// All counts in the order of the stages that a volume passes through. Those of the acquisition are from one
/// moment, so that their sum holds.
std::vector<NamedCount> named_counts(const PipelineCounters& pipeline, const ServerCounters& server);

}  // namespace fanlight
