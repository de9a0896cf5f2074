// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "proto/base/counter.hpp"
#include "proto/base/counter_table.hpp"
#include "proto/model/sweep_warnings.hpp"

// Each struct of counters is followed by its table, which gives every counter the name and the help text of
// its metric. A new counter needs a member and a row. The order of the rows is the order of the metrics.

namespace fanlight {

/// Written by the acquisition thread, in entries of `seq_lock`. At any moment
///   frames_received = frames_assembled + frames_invalid + frames_damaged + frames_cut + frames_misfit +
///                     frames_repeated + frames_late + frames_over_capacity + frames_in_short_volumes +
///                     frames_in_incomplete_volumes + frames_abandoned + frames_pending.
struct AcquisitionCounters {
  SeqLock seq_lock;
  Counter frames_received;
  Counter frames_assembled;              ///< in published volumes
  Counter frames_invalid;                ///< marked invalid by the source, or with a wrong angle
  Counter frames_damaged;                ///< with a wrong checksum
  Counter frames_cut;                    ///< that ended before their last pixel
  Counter frames_misfit;                 ///< whose size, pixel format or geometry differs from the source's
  Counter frames_repeated;               ///< with a sequence number that was received before
  Counter frames_late;                   ///< received after their sweep was closed
  Counter frames_over_capacity;          ///< of a sweep longer than announced, or than a volume can hold
  Counter frames_in_short_volumes;       ///< of sweeps dropped because their angle did not change
  Counter frames_in_incomplete_volumes;  ///< of sweeps dropped because too many of their frames are missing
  Counter
      frames_abandoned;  ///< of an unfinished sweep at a stop, a loss of the probe, or a change of geometry
  Gauge<std::uint64_t> frames_pending;  ///< of the sweep being filled

  // Not part of the sum.
  Counter frames_missing;        ///< gaps in the sequence: not received before their sweep had ended
  Counter frames_reordered;      ///< received after a later frame, and used
  Counter sequence_restarts;     ///< unannounced restarts of the sequence numbers
  Counter volumes_short;         ///< the sweeps of frames_in_short_volumes
  Counter volumes_incomplete;    ///< the sweeps of frames_in_incomplete_volumes
  Counter volumes_interpolated;  ///< published with gaps that were filled from neighbouring frames
  // Published with a SweepWarning, in its order.
  Counter volumes_copied;
  Counter volumes_blank;
  Counter volumes_out_of_order;
  Counter volumes_with_jump;
  Counter volumes_sparse;
  Counter volumes_mirrored;
  Counter volumes_of_rings;
  Counter geometry_changes;  ///< of the source, while it runs
  Counter source_delays;     ///< times that a replay fell behind its recorded times

  Gauge<double> frame_age_s;  ///< of the newest frame when it came, since its capture

  // Difference between forward and backward sweeps, see SweepHysteresis.
  Counter mismatch_estimates;       ///< pairs of sweeps that were compared
  Counter mismatch_refusals;        ///< pairs with too little in the frames to compare
  Gauge<double> mismatch_deg;       ///< estimated, and corrected in the angles
  Gauge<double> mismatch_left_deg;  ///< remaining difference of the newest pairs
  Gauge<double> mismatch_left_m;    ///< the same at half the depth

  /// Frames that were received and are in no volume: unusable themselves, or of sweeps that were dropped.
  std::uint64_t frames_unused() const {
    return frames_invalid.value() + frames_damaged.value() + frames_cut.value() + frames_misfit.value() +
           frames_repeated.value() + frames_late.value() + frames_over_capacity.value() +
           frames_in_short_volumes.value() + frames_in_incomplete_volumes.value() + frames_abandoned.value();
  }
  /// frames_unused() and the frames that were never received.
  std::uint64_t frames_lost() const { return frames_unused() + frames_missing.value(); }

  /// Whether the sum above holds now. Any thread.
  bool sum_holds() const {
    bool holds = false;
    seq_lock.read([&] {
      holds = frames_received.value() == frames_assembled.value() + frames_unused() + frames_pending.value();
    });
    return holds;
  }
};

inline constexpr auto kAcquisitionTable = std::to_array<CountRow<AcquisitionCounters>>({
    {"frames_received", "Frames received from the source", &AcquisitionCounters::frames_received},
    {"frames_assembled", "Frames in published volumes", &AcquisitionCounters::frames_assembled},
    {"frames_invalid", "Frames marked invalid or with a wrong angle", &AcquisitionCounters::frames_invalid},
    {"frames_damaged", "Frames with a wrong checksum", &AcquisitionCounters::frames_damaged},
    {"frames_cut", "Frames that ended before their last pixel", &AcquisitionCounters::frames_cut},
    {"frames_misfit", "Frames whose size, format or geometry differs from the source's",
     &AcquisitionCounters::frames_misfit},
    {"frames_repeated", "Frames received a second time", &AcquisitionCounters::frames_repeated},
    {"frames_late", "Frames received after the end of their sweep", &AcquisitionCounters::frames_late},
    {"frames_over_capacity", "Frames of sweeps longer than a volume can hold",
     &AcquisitionCounters::frames_over_capacity},
    {"frames_in_short_volumes", "Frames of sweeps whose angle did not move",
     &AcquisitionCounters::frames_in_short_volumes},
    {"frames_in_incomplete_volumes", "Frames of sweeps with too many missing frames",
     &AcquisitionCounters::frames_in_incomplete_volumes},
    {"frames_abandoned", "Frames of the sweep in progress when the source stopped or was lost",
     &AcquisitionCounters::frames_abandoned},
    {"frames_pending", "Frames of the sweep being filled", &AcquisitionCounters::frames_pending,
     CountKind::kNow},
    {"frames_missing", "Gaps in the frames' sequence", &AcquisitionCounters::frames_missing},
    {"frames_reordered", "Frames received out of order and used", &AcquisitionCounters::frames_reordered},
    {"sequence_restarts", "Times the frames' sequence restarted without notice",
     &AcquisitionCounters::sequence_restarts},
    {"volumes_short", "Sweeps dropped because their angle did not move", &AcquisitionCounters::volumes_short},
    {"volumes_incomplete", "Sweeps dropped because too many frames are missing",
     &AcquisitionCounters::volumes_incomplete},
    {"volumes_interpolated", "Volumes with missing frames, interpolated from their neighbours",
     &AcquisitionCounters::volumes_interpolated},
    {"volumes_copied", "Volumes with frames that are exact copies of their neighbours",
     &AcquisitionCounters::volumes_copied},
    {"volumes_blank", "Volumes with frames of a single grey level", &AcquisitionCounters::volumes_blank},
    {"volumes_out_of_order", "Volumes whose frames resemble distant frames more than their neighbours",
     &AcquisitionCounters::volumes_out_of_order},
    {"volumes_with_jump", "Volumes whose picture jumps between two neighbouring frames",
     &AcquisitionCounters::volumes_with_jump},
    {"volumes_sparse", "Volumes with neighbouring frames more than 5 deg apart",
     &AcquisitionCounters::volumes_sparse},
    {"volumes_mirrored", "Volumes that look like the mirror image of the one before",
     &AcquisitionCounters::volumes_mirrored},
    {"volumes_of_rings", "Volumes with the same echoes in all lines, as of a probe in air",
     &AcquisitionCounters::volumes_of_rings},
    {"geometry_changes", "Changes of the frames' geometry during the stream",
     &AcquisitionCounters::geometry_changes},
    {"source_delays", "Times that a replay fell 100 ms behind its recording",
     &AcquisitionCounters::source_delays},
    {"mismatch_estimates", "Pairs of sweeps compared for the mismatch of forward and backward sweeps",
     &AcquisitionCounters::mismatch_estimates},
    {"mismatch_refusals", "Pairs of sweeps with too little content to compare",
     &AcquisitionCounters::mismatch_refusals},
});

/// What counts each SweepWarning.
inline constexpr std::array<Counter AcquisitionCounters::*, kSweepWarnings> kWarnedVolumes = {
    &AcquisitionCounters::volumes_copied,       &AcquisitionCounters::volumes_blank,
    &AcquisitionCounters::volumes_out_of_order, &AcquisitionCounters::volumes_with_jump,
    &AcquisitionCounters::volumes_sparse,       &AcquisitionCounters::volumes_mirrored,
    &AcquisitionCounters::volumes_of_rings};

inline constexpr auto kAcquisitionValueTable = std::to_array<ValueRow<AcquisitionCounters>>({
    {"frame_age_seconds", "Age of the newest frame when it was received, since its capture",
     &AcquisitionCounters::frame_age_s},
    {"sweep_mismatch_degrees", "Mismatch of forward and backward sweeps that is corrected",
     &AcquisitionCounters::mismatch_deg},
    {"sweep_mismatch_left_degrees", "Remaining mismatch after the correction",
     &AcquisitionCounters::mismatch_left_deg},
    {"sweep_mismatch_left_metres", "Remaining mismatch at half the depth",
     &AcquisitionCounters::mismatch_left_m},
});

/// Written by the acquisition thread if the source is a USB probe.
struct ProbeCounters {
  Counter bytes_received;
  Counter bytes_skipped;  ///< noise: bytes between frames that belong to no frame
  Counter transfers_completed;
  Counter transfers_short;       ///< ended within a frame
  Counter transfers_stalled;     ///< the endpoint was halted, and cleared again
  Counter transfers_timed_out;   ///< no byte was received for 1.5 s; the stream was restarted
  Counter transfers_overflowed;  ///< the probe sent more than was requested
  Counter transfers_failed;      ///< any other error on the bus
  Counter transfers_refused;     ///< the operating system did not accept a read
  Counter streams_restarted;
  Counter requests_failed;  ///< control requests that the probe did not answer, or stalled
  Counter probes_found;
  Counter probes_lost;
  Counter settings_taken;
  Counter settings_refused;
};

inline constexpr auto kProbeTable = std::to_array<CountRow<ProbeCounters>>({
    {"probe_bytes_received", "Bytes received over USB", &ProbeCounters::bytes_received},
    {"probe_bytes_skipped", "Bytes between frames that belong to no frame", &ProbeCounters::bytes_skipped},
    {"probe_transfers_completed", "Transfers completed", &ProbeCounters::transfers_completed},
    {"probe_transfers_short", "Transfers that ended within a frame", &ProbeCounters::transfers_short},
    {"probe_transfers_stalled", "Halts of the probe's pipe", &ProbeCounters::transfers_stalled},
    {"probe_transfers_timed_out", "Transfers that timed out", &ProbeCounters::transfers_timed_out},
    {"probe_transfers_overflowed", "Transfers with more data than requested",
     &ProbeCounters::transfers_overflowed},
    {"probe_transfers_failed", "Transfers with another error on the bus", &ProbeCounters::transfers_failed},
    {"probe_transfers_refused", "Transfers that the system refused", &ProbeCounters::transfers_refused},
    {"probe_streams_restarted", "Times the probe was stopped and started again",
     &ProbeCounters::streams_restarted},
    {"probe_requests_failed", "Requests that the probe did not answer", &ProbeCounters::requests_failed},
    {"probes_found", "Times a probe was found and claimed", &ProbeCounters::probes_found},
    {"probes_lost", "Times a probe was lost", &ProbeCounters::probes_lost},
    {"probe_settings_taken", "Settings that the probe accepted", &ProbeCounters::settings_taken},
    {"probe_settings_refused", "Settings that the probe refused", &ProbeCounters::settings_refused},
});

/// Written by the acquisition thread if the source is an OpenIGTLink server.
///   messages_received = messages_used + messages_ignored + messages_damaged + messages_malformed +
///                       messages_too_long
struct IgtlCounters {
  Counter bytes_received;
  Counter messages_received;
  Counter messages_used;       ///< images, poses, and what keeps the connection alive
  Counter messages_ignored;    ///< of types that a source has no use for, or of other devices
  Counter messages_damaged;    ///< with a wrong checksum
  Counter messages_malformed;  ///< whose content contradicts its type or its length
  Counter messages_too_long;   ///< skipped: no image is as long
  Counter images_not_placed;   ///< without an angle: no transform of their time came, or it lies outside of
                               ///< the fan
  Counter images_cut;          ///< of several parts, of which some did not come
  Counter images_before_fan;   ///< used to find out the geometry; frames come after them
  Counter places_lost;         ///< bytes that are no head, or a wrong length: the connection was reopened
  Counter silences;            ///< nothing was received for ten seconds; the connection was reopened
  Counter connections_made;
  Counter connections_failed;
  Counter connections_lost;
};

inline constexpr auto kIgtlTable = std::to_array<CountRow<IgtlCounters>>({
    {"igtl_source_bytes_received", "Bytes received from the OpenIGTLink server",
     &IgtlCounters::bytes_received},
    {"igtl_source_messages_received", "OpenIGTLink messages received completely",
     &IgtlCounters::messages_received},
    {"igtl_source_messages_used", "OpenIGTLink images, poses and keep-alives", &IgtlCounters::messages_used},
    {"igtl_source_messages_ignored", "OpenIGTLink messages of other types or devices",
     &IgtlCounters::messages_ignored},
    {"igtl_source_messages_damaged", "OpenIGTLink messages with a wrong checksum",
     &IgtlCounters::messages_damaged},
    {"igtl_source_messages_malformed", "OpenIGTLink messages whose content contradicts their type or length",
     &IgtlCounters::messages_malformed},
    {"igtl_source_messages_too_long", "OpenIGTLink messages that were skipped as longer than any image",
     &IgtlCounters::messages_too_long},
    {"igtl_source_images_not_placed", "Images without a pose at their time, or with one outside the fan",
     &IgtlCounters::images_not_placed},
    {"igtl_source_images_cut", "Images with missing parts", &IgtlCounters::images_cut},
    {"igtl_source_images_before_fan", "Images used to determine the geometry",
     &IgtlCounters::images_before_fan},
    {"igtl_source_places_lost", "Times that the data were not a message and the connection was reopened",
     &IgtlCounters::places_lost},
    {"igtl_source_silences",
     "Times that nothing was received for ten seconds and the connection was reopened",
     &IgtlCounters::silences},
    {"igtl_source_connections_made", "Connections to the OpenIGTLink server",
     &IgtlCounters::connections_made},
    {"igtl_source_connections_failed", "Failed attempts to connect to the OpenIGTLink server",
     &IgtlCounters::connections_failed},
    {"igtl_source_connections_lost", "Connections to the OpenIGTLink server that ended",
     &IgtlCounters::connections_lost},
});

/// Written by the frame queue, on the acquisition thread. Every frame that was committed while there was a
/// queue is counted in exactly one of the two.
struct QueueCounters {
  Counter frames_fed;  ///< passed to the render thread before their volume
  Counter
      frames_not_fed;  ///< the queue was full, or the frame too large for it; they are read with the volume
};

inline constexpr auto kQueueTable = std::to_array<CountRow<QueueCounters>>({
    {"frames_fed", "Frames passed to the renderer ahead of their volume", &QueueCounters::frames_fed},
    {"frames_not_fed", "Frames that found no room in that queue and were passed with their volume only",
     &QueueCounters::frames_not_fed},
});

/// Written by the ring: volumes_published = volumes_taken + volumes_dropped + the volumes still waiting.
struct RingCounters {
  Counter volumes_published;
  Counter volumes_taken;    ///< read by the render thread
  Counter volumes_dropped;  ///< replaced unread by a newer one (newest wins)
};

inline constexpr auto kRingTable = std::to_array<CountRow<RingCounters>>({
    {"volumes_published", "Volumes put into the ring", &RingCounters::volumes_published},
    {"volumes_taken", "Volumes taken by the renderer", &RingCounters::volumes_taken},
    {"volumes_dropped", "Volumes replaced by a newer one before they were read",
     &RingCounters::volumes_dropped},
});

/// Written by the render thread. For the volumes that it took from its ring
///   RingCounters::volumes_taken = volumes_rendered + volumes_skipped + volumes_refused + volumes_unwatched +
///                                 those in flight.
/// At most two volumes are in flight: none at rest, and none after the renderer was destroyed. A thread that
/// reads volumes_taken last never finds it smaller than the sum of the others.
///   pass2_runs = pictures_finished + pictures_outdated + pictures_lost + those in flight
///   pictures_finished = read + pictures_replaced + the one still unread
struct RenderCounters {
  Counter volumes_rendered;   ///< with at least one picture
  Counter volumes_skipped;    ///< given up at the end, or outdated, before their first picture
  Counter volumes_refused;    ///< with a geometry that this GPU has no room for
  Counter volumes_unwatched;  ///< not rendered, since there were no viewers
  /// Cast without the requested speckle filter: too large for this GPU's buffers.
  Counter volumes_unfiltered;
  Counter pass1_runs;  ///< ray casts: a moved light never increments this
  Counter pass2_runs;  ///< filter, light and finish
  /// Of those, over the changed part of the picture only; the rest is as in the last one, bit by bit.
  Counter pass2_parts;
  Counter pictures_finished;
  Counter pictures_outdated;  ///< done after a picture of a newer volume, and therefore not shown
  Counter pictures_lost;      ///< under way when the GPU was lost
  Counter pictures_replaced;  ///< replaced unread in the picture mailbox by a newer one
  Counter devices_lost;       ///< the GPU was lost or hung, or had no memory left

  // Of private views. None of the above counts them.
  Counter private_casts;
  Counter private_casts_given_up;   ///< the main view took their frames, or the view was closed
  Counter private_lights_given_up;  ///< the view was closed, or frames of another size came
  Counter private_pictures;
  Counter private_views_refused;  ///< for which this GPU had no memory, or whose work failed

  /// Fraction of the last one or two seconds in which the main view had work in progress. Not a metric.
  Gauge<double> main_busy_share;
  /// fanlight::now_ns when the render thread last looked for work: old where a call of the GPU's driver does
  /// not return. 0 while it rests. Not a metric.
  Gauge<std::int64_t> turn_began_ns;
};

inline constexpr auto kRenderTable = std::to_array<CountRow<RenderCounters>>({
    {"volumes_rendered", "Volumes with a finished picture", &RenderCounters::volumes_rendered},
    {"volumes_skipped", "Volumes abandoned for a newer one before they had a picture",
     &RenderCounters::volumes_skipped},
    {"volumes_refused", "Volumes too large for this GPU", &RenderCounters::volumes_refused},
    {"volumes_unwatched", "Volumes not rendered because there were no viewers",
     &RenderCounters::volumes_unwatched},
    {"volumes_unfiltered", "Volumes too large for the speckle filter on this GPU, cast without it",
     &RenderCounters::volumes_unfiltered},
    {"pass1_runs", "Ray casts", &RenderCounters::pass1_runs},
    {"pass2_runs", "Runs of filter, light and finish", &RenderCounters::pass2_runs},
    {"pass2_parts", "Of those, over the changed part of the picture only", &RenderCounters::pass2_parts},
    {"pictures_finished", "Pictures rendered", &RenderCounters::pictures_finished},
    {"pictures_outdated", "Pictures finished after one of a newer volume",
     &RenderCounters::pictures_outdated},
    {"pictures_lost", "Pictures in progress when the GPU was lost", &RenderCounters::pictures_lost},
    {"pictures_replaced", "Pictures replaced before the server read them",
     &RenderCounters::pictures_replaced},
    {"devices_lost", "Times the GPU was lost or hung and was reopened", &RenderCounters::devices_lost},
    {"private_casts", "Ray casts of private views", &RenderCounters::private_casts},
    {"private_casts_given_up", "Of those, abandoned because the main view replaced their frames",
     &RenderCounters::private_casts_given_up},
    {"private_lights_given_up", "Pictures of private views abandoned after pass 1",
     &RenderCounters::private_lights_given_up},
    {"private_pictures", "Pictures of private views", &RenderCounters::private_pictures},
    {"private_views_refused", "Private views that the GPU had no memory for or failed to draw",
     &RenderCounters::private_views_refused},
});

/// The counters of all stages of the pipeline.
struct PipelineCounters {
  const AcquisitionCounters& acquisition;
  const RingCounters& ring;
  const QueueCounters& queue;
  const RenderCounters& render;
  const ProbeCounters& probe;
  const IgtlCounters& igtl;
};

// Every counter has a row in its table.
static_assert(sizeof(AcquisitionCounters) == sizeof(SeqLock) + kAcquisitionTable.size() * sizeof(Counter) +
                                                 kAcquisitionValueTable.size() * sizeof(Gauge<double>));
static_assert(sizeof(ProbeCounters) == kProbeTable.size() * sizeof(Counter));
static_assert(sizeof(IgtlCounters) == kIgtlTable.size() * sizeof(Counter));
static_assert(sizeof(QueueCounters) == kQueueTable.size() * sizeof(Counter));
static_assert(sizeof(RingCounters) == kRingTable.size() * sizeof(Counter));
static_assert(sizeof(RenderCounters) ==
              kRenderTable.size() * sizeof(Counter) + sizeof(Gauge<double>) + sizeof(Gauge<std::int64_t>));

}  // namespace fanlight
