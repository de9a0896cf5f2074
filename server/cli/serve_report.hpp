// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <filesystem>
#include <string>

#include "acquisition/source/frame_source.hpp"
#include "server/cli/serve_options.hpp"
#include "server/pipeline/pipeline.hpp"
#include "server/state/server_counters.hpp"

namespace fanlight {

/// $XDG_STATE_HOME/fanlight/presets.json, or the same in the user's home; empty where there is none.
std::filesystem::path usual_presets_file();

// What `fanlight serve` calls its source, and what it logs at its start and at its end.

/// Says what is shown without the path of a file, whose name may be a patient's. `source`: as given.
std::string usual_title(const std::string& source);

/// As sentences about a recording name its file; empty where the source is no recording.
std::string recording_path(const SourceDescription& source);

/// What protects the server, and which files it uses.
void log_service(const ServeOptions& options);
void log_device(const Pipeline& pipeline);
void log_source(const SourceDescription& source);

/// Where OpenIGTLink is served; a warning where others than this machine reach it.
void log_igtl(const boost::asio::ip::tcp::endpoint& endpoint);

/// Where pictures may be sent to by RTP; a warning where everyone on this machine may read the stream's key.
void log_rtp(const RtpOptions& options);

/// "phantom: delivers 60 frames a volume, each of ...", for people.
std::string source_words(const SourceDescription& source);

/// What became of the frames, in a sentence for people; then the counts of what went wrong, if anything did.
/// All counts are lines for --log-level debug, under their names.
void log_end(const PipelineCounters& pipeline, const ServerCounters& server, double ran_s);

/// What became of a recording that ended with the server.
void log_recording(Pipeline& pipeline);

}  // namespace fanlight
