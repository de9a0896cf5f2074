// SPDX-License-Identifier: Apache-2.0
#include "server/cli/serve_options.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <set>

#include "acquisition/phantom/phantom_options.hpp"
#include "acquisition/phantom/phantom_source.hpp"
#include "acquisition/record/recover_recording.hpp"
#include "acquisition/source/suggested_scene.hpp"
#include "acquisition/usb/usb_address.hpp"
#include "proto/base/printable.hpp"
#include "proto/model/look.hpp"
#include "server/access/credentials.hpp"
#include "server/cli/named_option.hpp"
#include "server/cli/probe_options.hpp"
#include "server/net/allowed_origins.hpp"
#include "server/net/listen_address.hpp"

namespace fanlight {

namespace {

/// A refused configuration is an error of usage, as one of the command line.
void require_given(const Result<void>& given) {
  if (!given) throw CLI::ConfigError(given.error().message);
}

std::string configuration_path(const ServeOptions& options) {
  if (!options.config.empty()) return options.config;
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no other thread runs yet
  const char* const path = std::getenv("FANLIGHT_CONFIG");
  return path == nullptr ? "" : path;
}

/// What else the server would refuse when it starts: reported with its place.
Result<void> check_value(const std::string& name, const std::string& value) {
  if (name == "listen") {
    if (const auto parsed = parse_listen_address(value); !parsed) return parsed.error();
  } else if (name == "size" || name == "size-max") {
    if (const auto parsed = parse_picture_size(value); !parsed) return parsed.error();
  } else if (name == "allow-origin") {
    if (const auto parsed = AllowedOrigins::parse(value); !parsed) return parsed.error();
  } else if (name == "look") {
    Scene scene;
    return apply_look(scene, value);
  }
  const auto field = std::ranges::find(scene_fields(), name, &SceneField::name);
  if (field == scene_fields().end()) return {};
  Scene scene;
  return set_field(scene, *field, std::string_view(value));
}

/// After the command line was read. Throws CLI::ConfigError.
void take_other_sources(CLI::App& command, ServeOptions& options) {
  options.misspelt = misspelt_variables(command);
  options.given_before = command_line_options(command);
  const auto environment = environment_options(command);
  options.given_before.insert(options.given_before.end(), environment.begin(), environment.end());
  require_given(apply_options(command, options.given_before, check_value, options.origins));
  options.config = configuration_path(options);
  if (!options.config.empty()) {
    auto configured = read_configuration(options.config);
    if (!configured) throw CLI::ConfigError(configured.error().message);
    options.configured = *std::move(configured);
    require_given(apply_options(command, options.configured, check_value, options.origins));
  }
  require_given(check_together(command, options.origins));
}

}  // namespace

// The order of the options is that of --help.

void ServeOptions::add_network_options(CLI::App& command) {
  command.option_defaults()->group("Network");
  command
      .add_option("--listen", listen,
                  "Address and port to listen on; a port alone means this machine only, port 0 any free port")
      ->capture_default_str()
      ->type_name("ADDRESS");
  auto* const certificate =
      command.add_option("--tls-certificate", tls.certificate, "Server certificate with its chain, PEM")
          ->type_name("FILE");
  auto* const key =
      command.add_option("--tls-key", tls.key, "Private key of the certificate, PEM")->type_name("FILE");
  certificate->needs(key);
  key->needs(certificate);
  command
      .add_flag("--hsts", hsts,
                "Send HSTS: browsers use only TLS for this host, on all its ports, for a year")
      ->needs(certificate);
  command.add_option("--client-ca", tls.client_ca, "CA certificate that signs client certificates, PEM")
      ->needs(certificate)
      ->type_name("FILE");
  command
      .add_option(
          "--allow-origin", allow_origin,
          "Other sites whose pages may embed the page, and use the API and the stream with the rights of "
          "their user: origins such as https://ward.example, separated by commas")
      ->type_name("ORIGINS");
}

void ServeOptions::add_access_options(CLI::App& command) {
  command.option_defaults()->group("Access");
  command
      .add_option("--tokens", tokens,
                  "File of access tokens, written by `fanlight token`; reloaded when it changes")
      ->type_name("FILE");
  command
      .add_option("--audit-log", audit_log, "Append a line of JSON for each change and login to this file")
      ->type_name("FILE");
  command.add_flag("--audit-required", audit_required,
                   "Refuse changes while the audit log cannot be written; needs --audit-log");
  command.add_option("--audit-log-mb", audit_log_mb, "Rotate the audit log at this size; 0: never")
      ->capture_default_str()
      ->check(CLI::Range(0, 1'000'000))
      ->type_name("MB");
  command
      .add_option("--control-lapse", control_lapse_s,
                  "Release the control of a display that has been silent for this time")
      ->capture_default_str()
      ->check(CLI::Range(1, 86400))
      ->type_name("SECONDS");
  command
      .add_option("--private-views", private_views,
                  "Maximum number of displays with a light or a camera of their own")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{0}, kMostPrivateViews))
      ->type_name("N");
  command
      .add_option("--presets", presets,
                  "File for saved presets; by default presets.json in the user's state folder")
      ->type_name("FILE");
  command
      .add_option("--archive-queue", archive_queue,
                  "Folder for stills, clips and volumes that operators send to a DICOM archive (PACS) from "
                  "the page; `fanlight send "
                  "--queue FOLDER --follow` sends them. It shows patients: keep it on an encrypted disk")
      ->type_name("FOLDER");
}

void ServeOptions::add_source_options(CLI::App& command) {
  command.option_defaults()->group("Source");
  command
      .add_option("SOURCE,--source", source,
                  "phantom: (the simulated probe), a recording's path or replay:PATH, "
                  "usb:VENDOR:PRODUCT[:SERIAL] (a probe), or igtl:HOST[:PORT] (a scanner by OpenIGTLink)")
      ->capture_default_str()
      ->type_name("SOURCE");
  command.add_option("--title", title, "Name shown on displays; only an admin sees the source itself")
      ->type_name("TEXT");
  command.option_defaults()->group("Playback");
  command
      .add_option("--geometry", playing.geometry_path,
                  "TOML file with the geometry of the recording, or of OpenIGTLink's images")
      ->type_name("FILE");
  add_named_option<ReplaySource::Ending, ReplaySource::Ending>(
      command, "--ending", playing.ending,
      {{"once", ReplaySource::Ending::kOnce},
       {"loop", ReplaySource::Ending::kLoop},
       {"to-and-fro", ReplaySource::Ending::kToAndFro}},
      "What to do after the last frame of the recording", "to-and-fro");
  command.add_option("--speed", playing.speed, "Playback speed: 1 is as recorded, 0.01 to 1000")
      ->capture_default_str()
      ->check([](const std::string& text) {
        double speed = 0;
        const char* const end = text.data() + text.size();
        const auto read = std::from_chars(text.data(), end, speed);
        const bool good =
            read.ec == std::errc{} && read.ptr == end && speed >= 0.01 && speed <= 1000;  // no NaN
        return good ? "" : fmt::format("Value {} not in range 0.01 to 1000", text);
      })
      ->type_name("FACTOR");
  command.add_option("--from", playing.from_s, "Start position in the recording")
      ->capture_default_str()
      ->type_name("SECONDS");
  command.add_flag("--paused", playing.paused,
                   "Show the first sweep, and wait until a display starts playback");
  command.add_flag_callback(
      "--fast", [this] { playing.pace = SourcePace::kAsFastAsTaken; },
      "Play as fast as possible, and render every volume");
}

void ServeOptions::add_picture_options(CLI::App& command) {
  command.option_defaults()->group("Picture");
  command.add_option("--size", size, "Size of the picture in pixels")
      ->capture_default_str()
      ->type_name("WxH");
  command
      .add_option("--size-max", size_max,
                  "Largest size for displays that show more pixels, rendered when there is time")
      ->capture_default_str()
      ->type_name("WxH");
  command.add_option("--gpu", gpu, "GPU to use, by a part of its name")->type_name("NAME");
  command.add_option("--jpeg-quality", jpeg_quality, "JPEG quality, 1 to 100")
      ->capture_default_str()
      ->check(CLI::Range(1, 100))
      ->type_name("N");
  automatic.add_to(command);
}

void ServeOptions::add_volume_options(CLI::App& command) {
  command.option_defaults()->group("Volumes");
  command.add_option("--ring", ring_slots, "Number of volumes in the ring, 3 to 64")
      ->capture_default_str()
      ->check(CLI::Range(3, 64))
      ->type_name("N");
  command
      .add_option(
          "--cine-volumes", cine_volumes,
          "Number of past volumes to keep for the cine, 0 to 1000; fewer if they would take more than "
          "512 MB")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000))
      ->type_name("N");
  add_named_option<std::optional<RingPolicy>, RingPolicy>(
      command, "--policy", policy,
      {{"newest-wins", RingPolicy::kNewestWins}, {"process-all", RingPolicy::kProcessAll}},
      "If volumes arrive faster than they are rendered: newest-wins drops older ones, process-all makes the "
      "source wait; the default is newest-wins, with --fast process-all");
  command.add_flag("--render-unwatched", render_unwatched,
                   "Render every volume, even if no display, script or recording needs a picture");
  add_named_option<MismatchCorrection, MismatchCorrection>(
      command, "--mismatch", mismatch,
      {{"corrected", MismatchCorrection::kOn}, {"as-measured", MismatchCorrection::kOff}},
      "Angles if forward and backward sweeps disagree", "corrected");
}

void ServeOptions::add_service_options(CLI::App& command) {
  command.option_defaults()->group("Configuration and log");
  command
      .add_option("--config", config,
                  "Read options from a TOML file; the command line and the environment take precedence")
      ->type_name("FILE");
  command.add_flag("--print-config", print_config,
                   "Print the options in effect as such a file, with their origins, and exit");
  command.add_option("--log-level", log_level, "Lowest level of the lines to log")
      ->default_str("info")
      ->check(CLI::IsMember({"error", "warning", "info", "debug"}).description(""))
      ->type_name("error|warning|info|debug");
  command.add_option("--log-format", log_format, "Log plain lines, or a JSON object per line")
      ->capture_default_str()
      ->check(CLI::IsMember({"text", "json"}).description(""))
      ->type_name("text|json");
}

void ServeOptions::add_to(CLI::App& command) {
  add_source_options(command);
  add_network_options(command);
  igtl.add_to(command);
  rtp.add_to(command);
  add_access_options(command);
  add_picture_options(command);
  add_volume_options(command);
  command.option_defaults()->group("Recording");
  recording.add_to(command);
  add_probe_options(command, playing);
  add_named_option<ProbeControl, ProbeControl>(
      command, "--probe-control", probe_control,
      {{"everyone", ProbeControl::kEveryone}, {"nobody", ProbeControl::kNobody}},
      "Who may change the settings of the probe: the display in control (everyone), or nobody", "everyone")
      ->group("USB probe");
  add_service_options(command);
  scene.add_to(command);
  command.parse_complete_callback([this, &command] { take_other_sources(command, *this); });
}

namespace {

std::string value_of(const std::vector<ConfiguredOption>& options, const std::string& name) {
  const auto found = std::ranges::find(options, name, &ConfiguredOption::name);
  return found == options.end() ? "" : found->value;
}

}  // namespace

Error ServeOptions::placed(const std::string& name, Error refusal) const {
  const auto origin = origins.find(name);
  if (origin != origins.end() && !is_of_command_line(origin->second))
    refusal.message = fmt::format("{}: {}", origin->second, refusal.message);
  return refusal;
}

Result<void> ServeOptions::check_inputs() const {
  constexpr std::string_view kProbe = "usb:";
  constexpr std::string_view kIgtl = "igtl:";
  constexpr std::string_view kPhantom = "phantom:";
  const std::filesystem::path& geometry = playing.geometry_path;
  if (!geometry.empty() && !std::filesystem::exists(geometry)) {
    return placed("geometry", {ErrorCode::kNotFound, fmt::format("{} is not there, expected a TOML file",
                                                                 printable(geometry.string()))});
  }
  if (source.starts_with(kProbe)) {
    const auto address = UsbAddress::parse(std::string_view(source).substr(kProbe.size()));
    if (!address) return placed("source", address.error());
  } else if (source.starts_with(kIgtl)) {
    const auto address = IgtlAddress::parse(std::string_view(source).substr(kIgtl.size()));
    if (!address) return placed("source", address.error());
  } else if (source.starts_with(kPhantom)) {  // which takes a second to make
    const auto parsed = parse_phantom(std::string_view(source).substr(kPhantom.size()), usual_phantom());
    if (!parsed) return placed("source", parsed.error());
    if (const auto shown = scene.applied_to(Scene{}); !shown) return shown.error();
  } else if (!is_unfinished(source)) {  // to open one would finish it
    Doorbell acquisition_bell;
    Doorbell server_bell;
    ProbeLink none(acquisition_bell, server_bell);
    const auto opened = open_source(source, playing, none, nullptr);
    if (!opened) return source_refusal(opened.error());
    if (const auto shown = scene.applied_to(suggested_scene((*opened)->description())); !shown)
      return shown.error();
  }
  if (!audit_log.empty()) {
    const std::filesystem::path folder = std::filesystem::absolute(audit_log).parent_path();
    if (!std::filesystem::is_directory(folder)) {
      return placed("audit-log",
                    {ErrorCode::kNotFound, fmt::format("{} is not there, expected a folder for the audit log",
                                                       printable(folder.string()))});
    }
  }
  if (!tokens.empty()) {
    if (const auto known = Credentials::load(tokens); !known) return placed("tokens", known.error());
  }
  if (!tls.empty()) {
    if (const auto context = make_tls_context(tls); !context)
      return placed("tls-certificate", context.error());
  }
  return {};
}

Error ServeOptions::source_refusal(const Error& refusal) const {
  unsigned port = 0;
  const char* const end = source.data() + source.size();
  const auto [rest, failure] = std::from_chars(source.data(), end, port);
  const bool is_port = failure == std::errc() && rest == end && port <= 65535;
  if (std::error_code unknown; !is_port || std::filesystem::exists(source, unknown))
    return placed("source", refusal);
  return placed("source", {ErrorCode::kInvalidArgument,
                           fmt::format("there is no source \"{0}\", did you mean --listen {0}?", source)});
}

Result<std::vector<ServeOptions::Reread>> ServeOptions::read_again() {
  if (config.empty()) return std::vector<Reread>{};
  auto now = read_configuration(config);
  if (!now) return now.error();
  // As at a start, but for another object: what is refused changes nothing.
  CLI::App command;
  ServeOptions fresh;
  fresh.add_to(command);
  OptionOrigins places;
  for (const auto* const given : {&given_before, &*now}) {
    if (auto taken = apply_options(command, *given, check_value, places); !taken) return taken.error();
  }
  if (auto agree = check_together(command, places); !agree) return agree.error();
  std::set<std::string> names;
  for (const auto* const options : {&configured, &*now})
    for (const ConfiguredOption& option : *options) names.insert(option.name);
  std::vector<Reread> changes;
  for (const std::string& name : names) {
    if (value_of(configured, name) == value_of(*now, name)) continue;
    const auto origin = origins.find(name);
    // A new start would not take it either.
    if (origin != origins.end() && comes_before_file(origin->second)) continue;
    const bool takes = name == "title" || name == "control-lapse" || name == "log-level";
    changes.push_back({.name = name, .in_force = takes});
  }
  for (const Reread& change : changes) {
    if (!change.in_force) continue;
    if (change.name == "title") title = fresh.title;
    if (change.name == "control-lapse") control_lapse_s = fresh.control_lapse_s;
    if (change.name == "log-level") log_level = fresh.log_level;
    if (const auto place = places.find(change.name); place != places.end()) {
      origins[change.name] = place->second;
    } else {
      origins.erase(change.name);
    }
  }
  // What takes effect after a restart is reported each time until then.
  for (const Reread& change : changes) {
    if (!change.in_force) continue;
    std::erase_if(configured, [&](const ConfiguredOption& option) { return option.name == change.name; });
    const auto given = std::ranges::find(*now, change.name, &ConfiguredOption::name);
    if (given != now->end()) configured.push_back(*given);
  }
  return changes;
}

}  // namespace fanlight
