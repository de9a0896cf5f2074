// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <stdio_ext.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <memory>
#include <optional>

#include "acquisition/igtl/sent_frames.hpp"
#include "acquisition/open_source.hpp"
#include "acquisition/sequence/plus_fields.hpp"
#include "acquisition/source/suggested_scene.hpp"
#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "proto/base/version.hpp"
#include "renderer/cast_means.hpp"
#include "renderer/survey/auto_scene.hpp"
#include "renderer/survey/fluid_region.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/log_format.hpp"
#include "server/cli/own_terminal.hpp"
#include "server/cli/probe_options.hpp"
#include "server/cli/serve_options.hpp"
#include "server/cli/serve_report.hpp"
#include "server/cli/service_notifier.hpp"
#include "server/net/listen_address.hpp"
#include "server/pacs/still_queue.hpp"
#include "server/pipeline/pipeline.hpp"
#include "server/service/stream_server.hpp"
#include "server/state/path_privacy.hpp"

namespace fanlight {

namespace {

constexpr std::uint64_t kMostCineBytes = 512'000'000;

Result<void> check_audit(const ServeOptions& options) {
  if (!options.audit_required || !options.audit_log.empty()) return {};
  return options.placed("audit-required", {ErrorCode::kInvalidArgument,
                                           "there is no audit log to be written, expected --audit-log FILE"});
}

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

/// Another try would be refused as well: the process ends with the code of a wrong configuration.
Error wrong_configuration(Error refusal) {
  const bool is_wrong = refusal.code == ErrorCode::kBadInput || refusal.code == ErrorCode::kUnsupported ||
                        refusal.code == ErrorCode::kNotFound;
  if (is_wrong) refusal.code = ErrorCode::kInvalidArgument;
  return refusal;
}

/// A probe may be plugged in later, and a scanner switched on.
Error refused_source(const ServeOptions& options, const Error& refusal) {
  const Error placed = options.source_refusal(refusal);
  const bool may_come = options.source.starts_with("usb:") || options.source.starts_with("igtl:");
  return may_come && refusal.code != ErrorCode::kInvalidArgument ? placed : wrong_configuration(placed);
}

/// As many of the wanted volumes as kMostCineBytes holds.
std::uint32_t affordable_cine(std::uint32_t wanted, const SourceDescription& source) {
  const std::uint64_t volume_bytes =
      std::max(source.geometry.frame_bytes(), source.largest_frame_bytes) * source.frames_per_volume;
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, kMostCineBytes / volume_bytes));
}

RingPolicy policy_of(const ServeOptions& options) {
  const RingPolicy suitable =
      options.playing.pace == SourcePace::kAsFastAsTaken ? RingPolicy::kProcessAll : RingPolicy::kNewestWins;
  return options.policy.value_or(suitable);
}

/// Where every volume is to be rendered, no viewer is needed.
bool may_rest(const ServeOptions& options) {
  return !options.render_unwatched && policy_of(options) == RingPolicy::kNewestWins;
}

Pipeline::Config pipeline_config(const ServeOptions& options, const ServerDescription& server,
                                 const Scene& scene, std::uint32_t cine_volumes) {
  return {.size = server.picture_size,
          .largest_size = server.largest_picture_size,
          .scene = scene,
          .ring_slots = options.ring_slots,
          .cine_volumes = cine_volumes,
          .policy = policy_of(options),
          .mismatch = options.mismatch,
          // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing here writes the environment
          .pipeline_cache = {.folder = user_cache_folder(std::getenv("XDG_CACHE_HOME"), std::getenv("HOME")),
                             .log = [](const std::string& sentence) { spdlog::info("{}", sentence); }},
          .gpu = options.gpu,
          .recordings = options.recording.recorder(),
          .sends_frames = !options.igtl.listen.empty(),
          .acquires_early = policy_of(options) == RingPolicy::kNewestWins};
}

/// Ends the process at once, as main() would with this result. A thread is inside the GPU's driver and does
/// not come back: destructors and the driver's own handlers at an orderly exit would wait for it, or pull its
/// objects away.
[[noreturn]] void leave_hung_gpu(const Result<void>& served) {
  if (!served) print_error("fanlight serve", served.error().message);
  spdlog::shutdown();
  std::fflush(nullptr);
  std::_Exit(served ? 0 : 1);
}

/// The size of --size-max, which is not smaller than that of --size.
Result<PictureSize> largest_size(const ServeOptions& options, PictureSize size) {
  const auto largest = parse_picture_size(options.size_max);
  if (!largest) return largest.error();
  return PictureSize{std::max(largest->width, size.width), std::max(largest->height, size.height)};
}

/// The server's configuration but for what open_pipeline() adds. Refuses what is wrong before any device is
/// opened.
Result<StreamServer::Config> server_config(const ServeOptions& options) {
  const auto size = parse_picture_size(options.size);
  if (!size) return options.placed("size", size.error());
  const auto largest = largest_size(options, *size);
  if (!largest) return options.placed("size-max", largest.error());
  const auto endpoint = listen_endpoint(options);
  if (!endpoint) return options.placed("listen", endpoint.error());
  if (auto audit = check_audit(options); !audit) return audit.error();
  auto igtl = options.igtl.config(!options.tls.empty(), !options.tokens.empty());
  if (!igtl) return options.placed("igtl-listen", igtl.error());
  auto origins = AllowedOrigins::parse(options.allow_origin);
  if (!origins) return options.placed("allow-origin", origins.error());
  auto rtp = options.rtp.config();
  if (!rtp) return wrong_configuration(options.placed("rtp-to", rtp.error()));
  if (auto made = options.recording.make_folder(); !made) return options.placed("recordings", made.error());
  return StreamServer::Config{
      .endpoint = *endpoint,
      .state = {.description = {.picture_size = *size,
                                .largest_picture_size = *largest,
                                .jpeg_quality = options.jpeg_quality},
                .probe_control = options.probe_control,
                .most_private_views = options.private_views,
                .renders_unwatched = !may_rest(options),
                .recording = options.recording.config()},
      .tls = options.tls,
      .hsts = options.hsts,
      .allowed_origins = *std::move(origins),
      .credentials = options.tokens,
      .presets = options.presets.empty() ? usual_presets_file() : std::filesystem::path(options.presets),
      .audit_log = options.audit_log,
      .audit_rotate_bytes = options.audit_log_mb * 1'000'000,
      .audit_required = options.audit_required,
      .control_lapse_ms = std::llround(options.control_lapse_s * 1000),
      .igtl = *std::move(igtl),
      .rtp = *std::move(rtp)};
}

/// What opens the queue for an archive; empty where none is wanted.
OpenStillArchive archive_of(const ServeOptions& options) {
  if (options.archive_queue.empty()) return {};
  return [&options](StillQueue::Post post) -> Result<std::unique_ptr<StillArchive>> {
    auto queue = open_still_queue(options.archive_queue, std::move(post));
    if (!queue) return options.placed("archive-queue", queue.error());
    return queue;
  };
}

/// Before the server answers its signals, and after: a file that may be read again is read at the start
/// anyway. A log without a reader does not end the service.
void ignore_harmless_signals() {
  for (const int signal : {SIGPIPE, SIGHUP, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF})
    std::signal(signal, SIG_IGN);
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
  // It has no reader: no reason not to serve, nor to end with an error.
  __fpurge(stdout);
  std::clearerr(stdout);
  spdlog::warn("the address could not be printed on the standard output; it is {}", url);
}

/// What systemd's watchdog asks for, in addition to the server's own loop.
std::vector<LoopWatch::Loop> loops_of(const Pipeline& pipeline) {
  return {{.name = "acquisition",
           .pulse = &pipeline.acquisition_pulse(),
           .runs = [&pipeline] { return pipeline.source_state() == "running"; }},
          {.name = "rendering", .pulse = &pipeline.render_pulse(), .runs = [] { return true; }}};
}

/// SIGHUP: the configuration, where there is one.
void read_again(ServeOptions& options, StreamServer& server, spdlog::level::level_enum usual_level) {
  ServiceNotifier::reloading();
  const auto changes = options.read_again();
  if (!changes) {
    spdlog::error("the configuration is unchanged: {}", changes.error().message);
    return;
  }
  for (const ServeOptions::Reread& change : *changes) {
    if (change.in_force) {
      spdlog::info("the configuration has a new {}, which is in effect now", change.name);
    } else {
      spdlog::warn("the configuration has a new {}, which takes effect after a restart", change.name);
    }
  }
  server.set_title(options.title.empty() ? usual_title(options.source) : printable(options.title));
  server.set_control_lapse_ms(std::llround(options.control_lapse_s * 1000));
  spdlog::set_level(options.log_level.empty() ? usual_level : spdlog::level::from_str(options.log_level));
}

/// Finds surfaces for pictures of this size.
SurfaceFinder surface_finder(const ServerDescription& server) {
  return [size = server.picture_size](const Volume& volume, const Scene& scene,
                                      const std::stop_token& stop) -> std::optional<FoundSurface> {
    auto found = auto_scene(volume, scene, size, stop);
    if (!found) return std::nullopt;
    return FoundSurface{
        .scene = found->scene, .choices = std::move(found->choices), .is_sure = found->is_sure};
  };
}

v1::FluidRegion message_of(const FluidRegion& region) {
  v1::FluidRegion message;
  message.set_volume_mm3(region.volume_mm3);
  message.set_deviation_mm3(region.deviation_mm3);
  message.set_fluid_level(region.fluid_level);
  message.set_border_level(region.border_level);
  message.set_wall_level(region.wall_level);
  message.set_first_x_mm(region.box.first.x_mm);
  message.set_first_y_mm(region.box.first.y_mm);
  message.set_first_z_mm(region.box.first.z_mm);
  message.set_step_mm(region.box.step_mm);
  message.set_columns(region.box.size[0]);
  message.set_rows(region.box.size[1]);
  message.set_slices(region.box.size[2]);
  message.set_depths(region.depths.data(), region.depths.size());
  return message;
}

Result<v1::FluidRegion> measured_fluid(const Volume& volume, const FluidQuestion& question,
                                       const std::stop_token& stop) {
  const auto region = grown_fluid(volume, {.at = question.at, .border_db = question.border_db}, stop);
  if (!region) return region.error();
  return message_of(*region);
}

/// Sets the log up as the options say. Returns the level that it had.
spdlog::level::level_enum begin_service_log(const ServeOptions& options) {
  const auto usual_level = spdlog::get_level();
  begin_log(options.log_format == "json");
  if (!options.log_level.empty()) spdlog::set_level(spdlog::level::from_str(options.log_level));
  for (const std::string& sentence : options.misspelt) spdlog::warn("{}", sentence);
  return usual_level;
}

/// A source and the pipeline that renders it.
struct RenderedSource {
  std::unique_ptr<FrameSource> source;
  SourceDescription description;  // as it was opened: the acquisition thread owns that of the source
  std::unique_ptr<Pipeline> pipeline;
  std::uint32_t cine_volumes = 0;
};

/// Fills in the source's description for clients.
void describe_source(const ServeOptions& options, const SourceDescription& source,
                     ServerState::Config& state) {
  ServerDescription& description = state.description;
  description.source = printable(source.name);
  description.title = options.title.empty() ? usual_title(options.source) : printable(options.title);
  description.path = recording_path(source);
  description.origin = source.origin;
  for (const std::string& note : source.notes)
    description.notes.push_back(without_path(printable(note), description.path, "the recording"));
  state.suggested_scene = suggested_scene(source);
  state.finds_view = finds_view(options.automatic, options.scene, source);
}

Result<RenderDevice> open_live_device(const std::string& name) {
  auto opened = open_device(name, live_device_options());
  if (opened && !opened->light_refusal.empty())
    spdlog::warn("there is no second device for passes 2 and 3 ({}): a changed light waits for pass 1",
                 opened->light_refusal);
  return opened;
}

/// Opens the source and the GPU, at the same time; completes the configuration of the server.
Result<RenderedSource> open_pipeline(const ServeOptions& options, SourceLink& link,
                                     ServerState::Config& state) {
  // Where the source is refused, the end of this function waits until the device is open.
  auto first_device = std::make_shared<std::future<Result<RenderDevice>>>(
      std::async(std::launch::async, open_live_device, options.gpu));
  if (const std::string note = opening_note(options.source, options.playing); !note.empty())
    spdlog::info("{}", note);
  auto source = open_source(options.source, options.playing, link.probe, &link.replay);
  if (!source) return refused_source(options, source.error());
  SourceDescription description = (*source)->description();
  describe_source(options, description, state);
  const auto scene = options.scene.applied_to(state.suggested_scene);
  if (!scene) return scene.error();
  state.initial_scene = {.revision = 1, .scene = *scene};
  state.chosen_fields = options.scene.given();

  const auto open = [first_device](const std::string& name) {
    return first_device->valid() ? first_device->get() : open_live_device(name);
  };
  const std::uint32_t cine_volumes = affordable_cine(options.cine_volumes, description);
  auto pipeline = Pipeline::create(pipeline_config(options, state.description, *scene, cine_volumes),
                                   {.open_device = open, .source = **source, .link = link});
  if (!pipeline) return pipeline.error();
  state.description.device = (*pipeline)->gpu().name;
  if (moves_smoothly(options, (*pipeline)->gpu())) {
    state.suggested_scene.deadline.plan = state.initial_scene.scene.deadline.plan =
        DeadlinePlan::kSmoothWhileMoving;
    Mailbox<NumberedScene>& scenes = (*pipeline)->ports().render.scenes;
    scenes.draft() = state.initial_scene;
    scenes.publish();
  }
  return RenderedSource{*std::move(source), std::move(description), *std::move(pipeline), cine_volumes};
}

void log_start(const ServeOptions& options, const RenderedSource& rendered) {
  spdlog::info("fanlight {}", version());
  log_service(options);
  log_device(*rendered.pipeline);
  log_source(rendered.description);
  spdlog::info("the ring of volumes takes up to {:.0f} MB, with the last {} volumes for a frozen display",
               static_cast<double>(rendered.pipeline->ring_capacity_bytes()) / 1e6, rendered.cine_volumes);
}

/// Starts the threads that do not run yet, and serves until the server ends.
Result<void> run(const ServeOptions& options, const RenderedSource& rendered, StreamServer& server) {
  rendered.pipeline->start();
  const std::string url = page_url(server.endpoint(), !options.tls.empty());
  print_address(rendered.description.name, url);
  spdlog::info("listening on {}", url);
  if (const auto igtl_endpoint = server.igtl_endpoint()) log_igtl(*igtl_endpoint);
  log_rtp(options.rtp);
  ServiceNotifier::ready(url);
  return server.run();
}

Result<void> serve(ServeOptions& options) {
  OwnTerminal terminal;
  ignore_harmless_signals();
  const auto usual_level = begin_service_log(options);
  auto config = server_config(options);
  if (!config) return config.error();
  SourceLink link;
  const std::int64_t began_ns = now_ns();
  auto rendered = open_pipeline(options, link, config->state);
  if (!rendered) return rendered.error();
  Pipeline& pipeline = *rendered->pipeline;

  RecordingFacts sent_facts = facts_of(rendered->description);
  sent_facts.source = config->state.description.title;  // a path may name a patient
  SentFrames sent_frames(sent_facts);
  ServerCounters counters;
  ServiceNotifier notifier(loops_of(pipeline));
  std::unique_ptr<StreamServer> server;
  auto made = StreamServer::create(
      *config, {.ports = pipeline.ports(),
                .counters = counters,
                .find_surface = surface_finder(config->state.description),
                .measure_fluid = measured_fluid,
                .write_frame =
                    [&](const QueuedFrame& frame, std::uint64_t utc_ns, FrameOrigin origin,
                        igtl::HeadVersion version) {
                      const std::int64_t age_ns = now_ns() - frame.stamp.capture_time_ns;
                      return sent_frames.message(
                          frame, {.utc_ns = utc_ns, .age_ns = age_ns, .origin = origin}, version);
                    },
                .hooks = {.second_passed =
                              [&](const PictureLiveness::Report& report) {
                                notifier.second_passed(report);
                                terminal.second_passed();
                              },
                          .read_again =
                              [&] {
                                if (terminal.has_closed()) return false;
                                read_again(options, *server, usual_level);
                                return true;
                              },
                          .was_read_again = [] { ServiceNotifier::reloaded(); },
                          .ends = [] { ServiceNotifier::stopping(); }},
                .open_archive = archive_of(options)});
  if (!made) return wrong_configuration(made.error());
  server = *std::move(made);

  log_start(options, *rendered);
  if (terminal.has_closed())
    return Error{ErrorCode::kStopped, "the terminal was closed, so the server stops"};
  Result<void> served = run(options, *rendered, *server);
  const bool stopped = pipeline.stop();
  log_recording(pipeline);
  log_end(pipeline.counters(), counters, static_cast<double>(now_ns() - began_ns) / 1e9);
  if (!stopped) {
    server.reset();  // it closes its files and connections
    leave_hung_gpu(served);
  }
  return served;
}

/// What --print-config refuses.
Result<void> check_start(const ServeOptions& options) {
  if (const auto endpoint = listen_endpoint(options); !endpoint)
    return options.placed("listen", endpoint.error());
  if (auto audit = check_audit(options); !audit) return audit;
  if (const auto igtl = options.igtl.config(!options.tls.empty(), !options.tokens.empty()); !igtl)
    return options.placed("igtl-listen", igtl.error());
  if (const auto rtp = options.rtp.config(); !rtp) return options.placed("rtp-to", rtp.error());
  const auto size = parse_picture_size(options.size);
  if (!size) return options.placed("size", size.error());
  if (const auto largest = largest_size(options, *size); !largest)
    return options.placed("size-max", largest.error());
  for (const std::string& sentence : options.misspelt) fmt::print(stderr, "fanlight serve: {}\n", sentence);
  return options.check_inputs();
}

}  // namespace

Command add_serve_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("serve", "Render a source live and stream it to displays");
  const auto options = std::make_shared<ServeOptions>();
  options->add_to(*command);
  return [options, command]() -> Result<void> {
    if (!options->print_config) return serve(*options);
    if (auto good = check_start(*options); !good) return wrong_configuration(good.error());
    fmt::print("{}", configuration_text(*command, options->origins));
    return {};
  };
}

}  // namespace fanlight
