// SPDX-License-Identifier: Apache-2.0
#include "server/cli/serve_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "proto/base/printable.hpp"

namespace fanlight {

std::filesystem::path usual_presets_file() {
  // NOLINTBEGIN(concurrency-mt-unsafe): no other thread runs yet
  const char* const state = std::getenv("XDG_STATE_HOME");
  const char* const home = std::getenv("HOME");
  // NOLINTEND(concurrency-mt-unsafe)
  constexpr const char* kFile = "fanlight/presets.json";
  if (state != nullptr && *state == '/') return std::filesystem::path(state) / kFile;
  return home != nullptr && *home == '/' ? std::filesystem::path(home) / ".local/state" / kFile : "";
}

std::string recording_path(const SourceDescription& source) {
  constexpr std::string_view kReplay = "replay:";
  return source.name.starts_with(kReplay) ? source.name.substr(kReplay.size()) : "";
}

std::string usual_title(const std::string& source) {
  if (source.starts_with("phantom:")) return "Phantom (simulated)";
  if (source.starts_with("igtl:")) return "Scanner (OpenIGTLink)";
  return source.starts_with("usb:") ? "Probe" : "Recording";
}

void log_service(const ServeOptions& options) {
  if (!options.config.empty()) spdlog::info("the configuration is {}", options.config);
  if (options.tls.empty()) {
    spdlog::info("without TLS{}: displays on this machine only", options.tokens.empty() ? " or tokens" : "");
  } else {
    spdlog::info("TLS with the certificate {}", options.tls.certificate.string());
  }
  if (!options.tokens.empty()) spdlog::info("tokens are in {}", options.tokens);
  if (!options.audit_log.empty()) spdlog::info("the audit log is {}", options.audit_log);
  if (!options.recording.folder.empty())
    spdlog::info("recordings go to {}", std::filesystem::absolute(options.recording.folder).string());
}

void log_igtl(const boost::asio::ip::tcp::endpoint& endpoint) {
  const std::string address = endpoint.address().to_string();
  spdlog::info("OpenIGTLink on {}:{}", endpoint.address().is_v6() ? "[" + address + "]" : address,
               endpoint.port());
  if (endpoint.address().is_loopback()) return;
  spdlog::warn("OpenIGTLink has neither encryption nor logins: everyone who reaches {} sees the pictures",
               endpoint.address().to_string());
}

void log_rtp(const RtpOptions& options) {
  if (options.to.empty()) return;
  if (!options.start) spdlog::info("an admin may send the pictures to {}", printable(options.to));
  struct stat status {};
  if (stat(options.key.c_str(), &status) == 0 && (status.st_mode & (S_IROTH | S_IWOTH)) != 0) {
    spdlog::warn(
        "{}: every user of this machine may read or write the key of the RTP stream, expected chmod 600",
        printable(options.key));
  }
}

void log_device(const Pipeline& pipeline) {
  for (const GpuCandidate& candidate : pipeline.gpus()) {
    if (!candidate.refusals.empty())
      spdlog::info("GPU {} cannot be used: {}", candidate.name, fmt::join(candidate.refusals, "; "));
  }
  const GpuCandidate& used = pipeline.gpu();
  spdlog::info("rendering on {}, a {}; driver: {}", used.name, used.kind, used.driver);
}

namespace {

std::string frame_words(const FanGeometry& geometry) {
  if (geometry.kind == FrameKind::kCartesian) {
    return fmt::format("{} x {} pixels of {:.4g} x {:.4g} mm", geometry.columns, geometry.rows,
                       geometry.pixel_width_mm, geometry.pixel_height_mm);
  }
  const std::string pitch = geometry.kind == FrameKind::kConvexLines
                                ? fmt::format("{:.3g} deg", geometry.line_pitch_deg)
                                : fmt::format("{:.4g} mm", geometry.pixel_width_mm);
  return fmt::format("{} scan lines, {} apart, of {} samples, {:.4g} mm apart", geometry.columns, pitch,
                     geometry.rows, geometry.pixel_height_mm);
}

}  // namespace

std::string source_words(const SourceDescription& source) {
  const FanGeometry& geometry = source.geometry;
  return fmt::format(
      "{} delivers {} frames a volume, each of {}; {:.1f} to {:.1f} deg about an axis {:.1f} mm "
      "behind the probe face",
      source.name, source.usual_frames > 0 ? source.usual_frames : source.frames_per_volume,
      frame_words(geometry), degrees(source.first_angle_rad), degrees(source.last_angle_rad),
      geometry.motor_radius_mm);
}

void log_source(const SourceDescription& source) {
  spdlog::info("source {}", source_words(source));
  for (const std::string& note : source.notes) spdlog::warn("{}", note);
}

namespace {

std::string duration_words(double seconds) {
  if (seconds < 100) return fmt::format("{:.0f} s", seconds);
  if (seconds < 6000) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

/// Whether a count other than zero is worth a person's attention: by a word of its name.
bool tells_of_trouble(std::string_view name) {
  constexpr std::string_view kWords[] = {
      "lost",  "damaged", "invalid", "dropped",  "refused",    "refusals", "failed", "missing",
      "late",  "cut",     "misfit",  "stalled",  "skipped",    "short",    "memory", "unanswered",
      "given", "evicted", "timed",   "outdated", "incomplete", "over"};
  while (!name.empty()) {
    const std::string_view word = name.substr(0, name.find('_'));
    if (std::ranges::find(kWords, word) != std::end(kWords)) return true;
    name.remove_prefix(std::min(word.size() + 1, name.size()));
  }
  return false;
}

}  // namespace

void log_end(const PipelineCounters& pipeline, const ServerCounters& server, double ran_s) {
  std::map<std::string_view, std::uint64_t> counts;
  std::vector<std::string> troubles;
  std::vector<std::string> all;
  for (const NamedCount& count : named_counts(pipeline, server)) {
    counts[count.name] = count.value;
    all.push_back(fmt::format("{} {}", count.name, count.value));
    if (count.value > 0 && tells_of_trouble(count.name))
      troubles.push_back(fmt::format("{}: {}", count.help, count.value));
  }
  spdlog::info(
      "ended after {}: {} frames became {} volumes, {} of them rendered; {} pictures finished, {} sent "
      "to {} displays",
      duration_words(ran_s), counts["frames_received"], counts["volumes_published"],
      counts["volumes_rendered"], counts["pictures_finished"], counts["pictures_sent"],
      counts["sessions_opened"]);
  if (!troubles.empty()) spdlog::info("problems: {}", fmt::join(troubles, "; "));
  spdlog::debug("all counts: {}", fmt::join(all, ", "));
}

void log_recording(Pipeline& pipeline) {
  const auto link = pipeline.ports().recording;
  const RecordingStatus* const status = link ? link->status.newest() : nullptr;
  if (status == nullptr) return;
  if (status->state == RecordingStatus::State::kFinishing) {
    spdlog::warn("{} is not finished; the next start does so, or fanlight recover", status->file);
  } else if (status->last_trouble.empty() && status->finished > 0) {
    spdlog::info("{} has {} frames in {:.1f} s", status->last_file, status->last_frames,
                 status->last_duration_s);
  }
}

}  // namespace fanlight
