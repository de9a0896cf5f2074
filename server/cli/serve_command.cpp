// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <stdio_ext.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>

#include "acquisition/open_source.hpp"
#include "acquisition/source/suggested_scene.hpp"
#include "proto/base/printable.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/cli/auto_view.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/log_format.hpp"
#include "server/cli/named_option.hpp"
#include "server/cli/probe_options.hpp"
#include "server/cli/recording_options.hpp"
#include "server/cli/scene_options.hpp"
#include "server/cli/serve_report.hpp"
#include "server/http/stream_server.hpp"
#include "server/net/listen_address.hpp"
#include "server/pipeline/pipeline.hpp"
#include "server/state/path_privacy.hpp"

namespace fanlight {

namespace {

constexpr std::uint64_t kMostCineBytes = 512'000'000;

struct ServeOptions {
  std::string source = "phantom:scene=face,probe=r2";
  std::string title;
  SourceOptions playing{.ending = ReplaySource::Ending::kToAndFro};
  std::string listen = "127.0.0.1:8080";
  TlsFiles tls;
  bool hsts = false;
  std::string tokens;
  std::string presets;
  std::string audit_log;
  std::uint64_t audit_log_mb = 0;
  double control_lapse_s = 60;
  std::size_t private_views = kMostPrivateViews;
  MismatchCorrection mismatch = MismatchCorrection::kOn;
  std::optional<RingPolicy> policy;  // absent: what suits the source
  ProbeControl probe_control = ProbeControl::kEveryone;
  std::string size = "512x512";
  std::string gpu;
  int jpeg_quality = 85;
  std::uint32_t ring_slots = 4;
  std::uint32_t cine_volumes = 32;
  bool render_unwatched = false;
  RecordingOptions recording;
  AutoOptions automatic;
  SceneOptions scene;
};

Result<boost::asio::ip::tcp::endpoint> listen_endpoint(const ServeOptions& options) {
  auto endpoint = parse_listen_address(options.listen);
  if (!endpoint) return endpoint;
  if (!endpoint->address().is_loopback() && (options.tls.empty() || options.tokens.empty())) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("listening on {} would let everyone on its network watch and control; expected "
                    "--tls-certificate, --tls-key and --tokens, or a loopback address such as 127.0.0.1:8080",
                    options.listen)};
  }
  if (!options.tls.client_ca.empty() && options.tokens.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "--client-ca says who signs certificates, not whose may come in; expected --tokens with "
                 "[[certificate]] "
                 "entries too"};
  }
  return endpoint;
}

/// As many of the wanted volumes as kMostCineBytes holds.
std::uint32_t affordable_cine(std::uint32_t wanted, const SourceDescription& source) {
  const std::uint64_t volume_bytes =
      std::max(source.geometry.frame_bytes(), source.largest_frame_bytes) * source.frames_per_volume;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, kMostCineBytes / volume_bytes));
}

RingPolicy policy_of(const ServeOptions& options) {
  const RingPolicy suitable =
      options.playing.as_fast_as_taken ? RingPolicy::kProcessAll : RingPolicy::kNewestWins;
  return options.policy.value_or(suitable);
}

/// Where every volume is to be rendered, nobody has to look.
bool may_rest(const ServeOptions& options) {
  return !options.render_unwatched && policy_of(options) == RingPolicy::kNewestWins;
}

Pipeline::Config pipeline_config(const ServeOptions& options, const PictureSize& size, const Scene& scene,
                                 std::uint32_t cine_volumes) {
  return {.size = size,
          .scene = scene,
          .ring_slots = options.ring_slots,
          .cine_volumes = cine_volumes,
          .policy = policy_of(options),
          .mismatch = options.mismatch,
          // NOLINTNEXTLINE(concurrency-mt-unsafe): no other thread runs yet
          .pipeline_cache = {.folder = user_cache_folder(std::getenv("XDG_CACHE_HOME"), std::getenv("HOME")),
                             .log = [](const std::string& sentence) { spdlog::info("{}", sentence); }},
          .gpu = options.gpu,
          .recordings = {.folder = options.recording.folder, .form = options.recording.form}};
}

/// Ends the process at once, as main() would with this result. A thread is inside the GPU's driver and does
/// not come back: destructors and the driver's own handlers at an orderly exit would wait for it, or pull its
/// objects away.
[[noreturn]] void leave_hung_gpu(const Result<void>& served) {
  if (!served) std::fprintf(stderr, "fanlight serve: %s\n", served.error().message.c_str());
  spdlog::shutdown();
  std::fflush(nullptr);
  std::_Exit(served ? 0 : 1);
}

/// The server's configuration but for the scenes, the source and the device.
StreamServer::Config server_config(const ServeOptions& options, const PictureSize& size) {
  return {.facts = {.picture_width = size.width,
                    .picture_height = size.height,
                    .jpeg_quality = options.jpeg_quality},
          .tls = options.tls,
          .hsts = options.hsts,
          .credentials = options.tokens,
          .presets = options.presets.empty() ? usual_presets_file() : std::filesystem::path(options.presets),
          .audit_log = options.audit_log,
          .audit_rotate_bytes = options.audit_log_mb * 1'000'000,
          .control_lapse_ms = std::llround(options.control_lapse_s * 1000),
          .probe_control = options.probe_control,
          .most_private_views = options.private_views,
          .recording = options.recording.config()};
}

StreamServer::Dependencies server_dependencies(Pipeline& pipeline, SourceLink& link,
                                               ServerCounters& counters) {
  return {.bell = link.server_bell,
          .pictures = pipeline.pictures(),
          .scenes = pipeline.scenes(),
          .failures = pipeline.failures(),
          .pipeline = pipeline.counters(),
          .probe = link.probe,
          .replay = link.replay,
          .counters = counters,
          .source_state = [&pipeline] { return pipeline.source_state(); },
          .private_views = &pipeline.private_views(),
          .private_view_ends = &pipeline.private_view_ends(),
          .render_health = &pipeline.render_health(),
          .survey_orders = &pipeline.survey_orders(),
          .survey_results = &pipeline.survey_results(),
          .recording = pipeline.recording(),
          .cine = &pipeline.cine()};
}

/// Before the server answers its signals, and after: a file that may be read again is read at the start
/// anyway. A log whose reader has gone does not end the service.
void ignore_harmless_signals() {
  for (const int signal : {SIGPIPE, SIGHUP, SIGUSR1}) std::signal(signal, SIG_IGN);
}

/// A processor casts a full picture too slowly to follow a hand.
bool moves_smoothly(const ServeOptions& options, const GpuCandidate& gpu) {
  const auto given = options.scene.given();
  return gpu.kind == kProcessorKind &&
         std::ranges::find(given, "deadline.plan", &SceneField::name) == given.end();
}

/// Scripts read the address from stdout.
void print_address(const std::string& source, const std::string& url) {
  fmt::print("Fanlight shows {} on {}\n", printable(source), url);
  if (std::fflush(stdout) == 0) return;
  // Nobody reads it: no reason not to serve, nor to end with an error.
  __fpurge(stdout);
  std::clearerr(stdout);
  spdlog::warn("the address could not be printed on the standard output; it is {}", url);
}

Result<void> serve(const ServeOptions& options) {
  ignore_harmless_signals();
  const auto size = parse_picture_size(options.size);
  if (!size) return size.error();
  StreamServer::Config config = server_config(options, *size);
  const auto endpoint = listen_endpoint(options);
  if (!endpoint) return endpoint.error();
  if (auto made = options.recording.make_folder(); !made) return made;
  config.endpoint = *endpoint;

  SourceLink link;
  const auto source = open_source(options.source, options.playing, link.probe, &link.replay);
  if (!source) return source.error();
  const SourceDescription& description = (*source)->description();
  config.facts.source = printable(description.name);
  config.facts.title = options.title.empty() ? usual_title(options.source) : printable(options.title);
  config.facts.path = recording_path(description);
  for (const std::string& note : description.notes)
    config.facts.notes.push_back(without_path(printable(note), config.facts.path, "the recording"));
  config.suggested_scene = suggested_scene(description);
  const auto scene = options.scene.applied_to(config.suggested_scene);
  if (!scene) return scene.error();
  config.initial_scene = {.revision = 1, .scene = *scene};
  config.chosen_fields = options.scene.given();
  config.finds_view = finds_view(options.automatic, options.scene, description);

  // Scripts read the standard output, so the log goes to stderr.
  spdlog::set_default_logger(spdlog::stderr_color_mt("fanlight"));
  spdlog::set_formatter(printable_log_format());
  const auto open = [](const std::string& name) {
    auto opened = open_device(name, {.own_light_device = true});
    if (opened && !opened->light_refusal.empty())
      spdlog::warn("a moved light waits for pass 1: there is no second device for it ({})",
                   opened->light_refusal);
    return opened;
  };
  const std::uint32_t cine_volumes = affordable_cine(options.cine_volumes, description);
  const auto pipeline = Pipeline::create(pipeline_config(options, *size, *scene, cine_volumes),
                                         {.open_device = open, .source = **source, .link = link});
  if (!pipeline) return pipeline.error();
  config.facts.device = (*pipeline)->gpu().name;
  if (moves_smoothly(options, (*pipeline)->gpu())) {
    config.suggested_scene.deadline.plan = config.initial_scene.scene.deadline.plan =
        DeadlinePlan::kSmoothWhileMoving;
    (*pipeline)->scenes().draft() = config.initial_scene;
    (*pipeline)->scenes().publish();
  }
  ServerCounters counters;
  StreamServer::Dependencies dependencies = server_dependencies(**pipeline, link, counters);
  if (may_rest(options)) dependencies.audience = &(*pipeline)->audience();
  auto server = StreamServer::create(config, dependencies);
  if (!server) return server.error();

  spdlog::info("fanlight {}", FANLIGHT_VERSION);
  log_device(**pipeline);
  log_source(description);
  if (!options.recording.folder.empty())
    spdlog::info("recordings go to {}", std::filesystem::absolute(options.recording.folder).string());
  spdlog::info("the ring of volumes takes up to {:.0f} MB, with the last {} volumes for a frozen display",
               static_cast<double>((*pipeline)->ring_capacity_bytes()) / 1e6, cine_volumes);
  (*pipeline)->start();
  print_address(description.name, page_url((*server)->endpoint(), !options.tls.empty()));
  Result<void> served = (*server)->run();
  const bool stopped = (*pipeline)->stop();
  log_recording(**pipeline);
  log_end((*pipeline)->counters(), counters);
  if (!stopped) {
    server->reset();  // it closes its files and connections
    leave_hung_gpu(served);
  }
  return served;
}

// The order of the options is that of --help.

void add_network_options(CLI::App& command, ServeOptions& options) {
  command.add_option("--listen", options.listen, "Address and port; port 0 takes a free one")
      ->capture_default_str()
      ->type_name("ADDR:PORT");
  auto* const certificate = command
                                .add_option("--tls-certificate", options.tls.certificate,
                                            "The server's, and those up to its root, PEM")
                                ->type_name("FILE");
  auto* const key =
      command.add_option("--tls-key", options.tls.key, "Its private key, PEM")->type_name("FILE");
  certificate->needs(key);
  key->needs(certificate);
  command
      .add_flag("--hsts", options.hsts,
                "Tell browsers to come to this host over TLS only, for a year; also to its other ports")
      ->needs(certificate);
  command.add_option("--client-ca", options.tls.client_ca, "Who signs clients' certificates, PEM")
      ->needs(certificate)
      ->type_name("FILE");
  command
      .add_option("--tokens", options.tokens,
                  "Who may come in, as `fanlight token` writes it; read again where it changes")
      ->type_name("FILE");
  command
      .add_option("--presets", options.presets,
                  "Keeps the presets that people save; else presets.json in the user's folder of states")
      ->type_name("FILE");
  command.add_option("--audit-log", options.audit_log, "Appends who changed what, a line of JSON each")
      ->type_name("FILE");
  command
      .add_option("--audit-log-mb", options.audit_log_mb,
                  "Size at which the audit log goes on in a new file; 0: never")
      ->capture_default_str()
      ->check(CLI::Range(0, 1'000'000))
      ->type_name("MB");
  command
      .add_option("--control-lapse", options.control_lapse_s,
                  "The control is free again after so much silence")
      ->capture_default_str()
      ->check(CLI::Range(1, 86400))
      ->type_name("S");
  command
      .add_option("--private-views", options.private_views,
                  "Displays that may have a light or a camera of their own at once")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{0}, kMostPrivateViews))
      ->type_name("N");
}

void add_source_options(CLI::App& command, ServeOptions& options) {
  command.add_option("--geometry", options.playing.geometry_path, "TOML file with the recording's geometry")
      ->type_name("FILE");
  add_named_option<ReplaySource::Ending, ReplaySource::Ending>(
      command, "--ending", options.playing.ending,
      {{"once", ReplaySource::Ending::kOnce},
       {"loop", ReplaySource::Ending::kLoop},
       {"to-and-fro", ReplaySource::Ending::kToAndFro}},
      "After the recording's last frame: once, loop or to-and-fro (the default)");
  command.add_option("--speed", options.playing.speed, "Of the recording: 1 as recorded, 0.01 to 1000")
      ->type_name("FACTOR");
  command.add_option("--from", options.playing.from_s, "Where the recording begins")->type_name("SECONDS");
  command.add_flag("--paused", options.playing.paused,
                   "Show the recording's first sweep, and wait for a display to play on");
  command.add_flag("--fast", options.playing.as_fast_as_taken,
                   "Play as fast as volumes are rendered, and render them all");
}

void add_picture_options(CLI::App& command, ServeOptions& options) {
  command.add_option("--size", options.size, "Of the picture, pixels")
      ->capture_default_str()
      ->type_name("WxH");
  command.add_option("--gpu", options.gpu, "Part of the name of the GPU to use")->type_name("NAME");
  command.add_option("--jpeg-quality", options.jpeg_quality, "1 to 100")
      ->capture_default_str()
      ->check(CLI::Range(1, 100))
      ->type_name("N");
}

void add_volume_options(CLI::App& command, ServeOptions& options) {
  command.add_option("--ring", options.ring_slots, "Volumes that the ring holds, 3 to 64")
      ->capture_default_str()
      ->check(CLI::Range(3, 64))
      ->type_name("N");
  command
      .add_option(
          "--cine-volumes", options.cine_volumes,
          "Last volumes that are kept for a frozen display, 0 to 1000; fewer where they would take over "
          "512 MB")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000))
      ->type_name("N");
  add_named_option<std::optional<RingPolicy>, RingPolicy>(
      command, "--policy", options.policy,
      {{"newest-wins", RingPolicy::kNewestWins}, {"process-all", RingPolicy::kProcessAll}},
      "Where volumes come faster than they are rendered: newest-wins drops older ones, process-all makes the "
      "source wait (the default with --fast)");
  command.add_flag("--render-unwatched", options.render_unwatched,
                   "Render every volume, also while no display, script or recording needs a picture");
  add_named_option<MismatchCorrection, MismatchCorrection>(
      command, "--mismatch", options.mismatch,
      {{"corrected", MismatchCorrection::kOn}, {"as-measured", MismatchCorrection::kOff}},
      "Where forward and backward sweeps disagree: corrected (the default), or angles as-measured");
}

}  // namespace

Command add_serve_command(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("serve", "Renders a source as it comes and streams it to displays");
  const auto options = std::make_shared<ServeOptions>();
  command
      ->add_option("--source", options->source,
                   "phantom: (the simulated probe), replay:PATH (a recording) or usb:VENDOR:PRODUCT[:SERIAL] "
                   "(a probe)")
      ->capture_default_str()
      ->type_name("SOURCE");
  command->add_option("--title", options->title, "What displays call it; only an admin is told the source")
      ->type_name("TEXT");
  add_network_options(*command, *options);
  add_source_options(*command, *options);
  options->recording.add_to(*command);
  add_picture_options(*command, *options);
  add_volume_options(*command, *options);
  add_probe_options(*command, options->playing);
  add_named_option<ProbeControl, ProbeControl>(
      *command, "--probe-control", options->probe_control,
      {{"everyone", ProbeControl::kEveryone}, {"nobody", ProbeControl::kNobody}},
      "Whether whoever is in control may set the probe: everyone (the default) or nobody");
  options->automatic.add_to(*command);
  options->scene.add_to(*command);
  return [options]() { return serve(*options); };
}

}  // namespace fanlight
