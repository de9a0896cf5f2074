#pragma once

#include <cstdint>
#include <vector>

#include "proto/counter.hpp"

namespace fanlight {

/// Raised by the server thread. pictures_offered = pictures_sent + pictures_skipped + those waiting or under
/// way, over all sessions.
struct ServerCounters {
  Counter sessions_opened;
  Counter sessions_closed;
  Counter connections_refused;            ///< beyond the limit
  Counter handshakes_failed;              ///< TLS that came to nothing
  Counter encodings_failed;               ///< sessions closed since their picture could not be encoded
  Counter sessions_stalled;               ///< dropped since they took nothing for five seconds
  Gauge<std::uint64_t> audit_lines_lost;  ///< that the disk had no room for
  Counter control_refusals;               ///< wishes to be in control that were not granted
  Counter requests_refused;  ///< HTTP that was malformed, too long or for something that is not there
  Counter messages_refused;  ///< malformed, oversized or unexpected WebSocket messages
  Counter scene_changes;
  Counter scene_refusals;  ///< changes with a value that is not allowed
  Counter probe_changes;
  Gauge<std::uint64_t> private_views;  ///< open now
  Counter private_view_refusals;
  Counter private_views_ended;  ///< since the main view had left them no time for five seconds
  Counter probe_refusals;       ///< changes of the probe that are not allowed, or that it did not take
  Counter pictures_encoded;
  Counter pictures_offered;
  Counter pictures_sent;
  Counter pictures_skipped;  ///< replaced unsent by a newer one, or unsent when the session ended
};

/// All counters of the house, for the metrics and the statistics.
struct HouseCounters {
  const AcquisitionCounters& acquisition;
  const RingCounters& ring;
  const FeedCounters& feed;
  const RenderCounters& render;
  const ProbeCounters& probe;
};

/// One count as a person reads it, in the metrics and when the server ends.
struct NamedCount {
  enum class Kind : std::uint8_t {
    kTotal,  ///< fanlight_NAME_total: only grows
    kNow,    ///< fanlight_NAME: as many as there are now
  };
  const char* name;
  const char* help;
  std::uint64_t value;
  Kind kind = Kind::kTotal;
};

/// One value that goes up and down, for the metrics.
struct NamedValue {
  const char* name;  ///< as in fanlight_NAME
  const char* help;
  double value;
};
std::vector<NamedValue> named_values(const HouseCounters& house);

/// Every count of the house, in the order of a volume's walk; those of the acquisition as of one moment.
std::vector<NamedCount> named_counts(const HouseCounters& house, const ServerCounters& server);

}  // namespace fanlight
