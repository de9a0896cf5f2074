#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/open_source.hpp"
#include "renderer/render_thread.hpp"
#include "server/commands.hpp"
#include "server/listen_address.hpp"
#include "server/named_option.hpp"
#include "server/probe_options.hpp"
#include "server/scene_options.hpp"
#include "server/stream_server.hpp"

namespace fanlight {

namespace {

struct ServeOptions {
  std::string source = "phantom:";
  SourceOptions playing{.ending = ReplaySource::Ending::kToAndFro};
  std::string geometry_path;
  std::string listen = "127.0.0.1:8080";
  TlsFiles tls;
  std::string tokens;
  std::string audit_log;
  double control_lapse_s = 60;
  std::size_t private_views = kMostPrivateViews;
  MismatchCorrection mismatch = MismatchCorrection::kOn;
  std::optional<RingPolicy> policy;  // absent: what suits the source
  ProbeControl probe_control = ProbeControl::kEveryone;
  std::string size = "512x512";
  std::string gpu;
  int jpeg_quality = 85;
  std::uint32_t ring_slots = 4;
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

void log_start(const SourceDescription& description, const GpuInstance& instance, const Gpu& gpu,
               const VolumeRing& ring) {
  spdlog::info("fanlight {}", FANLIGHT_VERSION);
  for (const GpuCandidate& candidate : instance.candidates()) {
    if (!candidate.refusals.empty())
      spdlog::info("GPU {} does not serve: {}", candidate.name, fmt::join(candidate.refusals, "; "));
  }
  spdlog::info("renders on {} ({}, {})", gpu.candidate().name, gpu.candidate().kind, gpu.candidate().driver);
  const FanGeometry& geometry = description.geometry;
  spdlog::info(
      "source {}: {} frames a volume of {} x {} pixels of {:.4f} x {:.4f} mm, {:.1f} to {:.1f} deg about an "
      "axis {:.1f} mm "
      "behind the probe face",
      description.name,
      description.usual_frames > 0 ? description.usual_frames : description.frames_per_volume,
      geometry.columns, geometry.rows, geometry.pixel_width_mm, geometry.pixel_height_mm,
      degrees(description.first_angle_rad), degrees(description.last_angle_rad), geometry.motor_radius_mm);
  spdlog::info("the ring of volumes takes up to {:.0f} MB", static_cast<double>(ring.capacity_bytes()) / 1e6);
}

void log_end(const HouseCounters& house, const ServerCounters& server) {
  std::string counts;
  for (const NamedCount& count : named_counts(house, server)) {
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count.name, count.value);
  }
  spdlog::info("ended: {}", counts);
}

std::string state_text(const AcquisitionThread& acquisition) {
  switch (acquisition.state()) {
    case AcquisitionThread::State::kRunning:
      return "running";
    case AcquisitionThread::State::kFailed:
      return acquisition.error().message;
    default:
      return "ended";
  }
}

Result<void> serve(const ServeOptions& options) {
  const auto size = parse_picture_size(options.size);
  if (!size) return size.error();
  const auto endpoint = listen_endpoint(options);
  if (!endpoint) return endpoint.error();
  SourceOptions playing = options.playing;
  playing.geometry_path = options.geometry_path;
  // Who meets whom where: the three threads share these and nothing else.
  Doorbell acquisition_bell;
  Doorbell render_bell;
  Doorbell server_bell;
  AcquisitionCounters acquisition_counters;
  RenderCounters render_counters;
  ServerCounters server_counters;
  ProbeLink probe(acquisition_bell, server_bell);

  const auto source = open_source(options.source, playing, probe);
  if (!source) return source.error();
  const SourceDescription& description = (*source)->description();
  const Scene suggested =
      scene_for(description.geometry, description.first_angle_rad, description.last_angle_rad);
  const auto scene = options.scene.applied_to(suggested);
  if (!scene) return scene.error();
  const NumberedScene initial{.revision = 1, .scene = *scene};

  const auto instance = GpuInstance::create({});
  if (!instance) return instance.error();
  const auto gpu = Gpu::create(**instance, options.gpu);
  if (!gpu) return gpu.error();

  const RingPolicy suitable = playing.as_fast_as_taken ? RingPolicy::kProcessAll : RingPolicy::kNewestWins;
  VolumeRing ring({.geometry = description.geometry,
                   .frame_capacity = description.frames_per_volume,
                   .slots = options.ring_slots,
                   .policy = options.policy.value_or(suitable),
                   .largest_frame_bytes = description.largest_frame_bytes},
                  {.reader_bell = render_bell, .writer_bell = acquisition_bell});
  FrameFeed feed({.largest_frame_bytes = std::max<std::uint64_t>(description.geometry.frame_bytes(),
                                                                 description.largest_frame_bytes)},
                 {.reader_bell = render_bell});
  Mailbox<NumberedScene> scenes(render_bell);
  Mailbox<PrivateViews> private_views(render_bell);
  Mailbox<Picture> pictures(server_bell, blank_picture(size->width, size->height));
  Mailbox<Error> failures(server_bell);

  auto renderer = Renderer::create({.size = *size,
                                    .geometry = description.geometry,
                                    .first_angle_rad = description.first_angle_rad,
                                    .last_angle_rad = description.last_angle_rad,
                                    .frame_capacity = description.frames_per_volume,
                                    .usual_frames = description.usual_frames},
                                   {.gpu = **gpu, .counters = render_counters}, initial);
  if (!renderer) return renderer.error();

  const HouseCounters house{acquisition_counters, ring.counters(), feed.counters(), render_counters,
                            probe.counters};
  const AcquisitionThread* acquisition = nullptr;
  const auto server =
      StreamServer::create({.endpoint = *endpoint,
                            .facts = {.source = description.name,
                                      .device = (*gpu)->candidate().name,
                                      .picture_width = size->width,
                                      .picture_height = size->height,
                                      .jpeg_quality = options.jpeg_quality},
                            .initial_scene = initial,
                            .suggested_scene = suggested,
                            .tls = options.tls,
                            .credentials = options.tokens,
                            .audit_log = options.audit_log,
                            .control_lapse_ms = std::llround(options.control_lapse_s * 1000),
                            .probe_control = options.probe_control,
                            .most_private_views = options.private_views},
                           {.bell = server_bell,
                            .pictures = pictures,
                            .scenes = scenes,
                            .failures = failures,
                            .house = house,
                            .probe = probe,
                            .counters = server_counters,
                            .source_state = [&acquisition] { return state_text(*acquisition); },
                            .private_views = &private_views});
  if (!server) return server.error();

  // stdout is for the address alone, so that a script can read it.
  spdlog::set_default_logger(spdlog::stderr_color_mt("fanlight"));
  log_start(description, **instance, **gpu, ring);
  Result<void> served;
  {
    const RenderThread render_thread(std::move(*renderer), {.ring = ring,
                                                            .scenes = scenes,
                                                            .pictures = pictures,
                                                            .counters = render_counters,
                                                            .bell = render_bell,
                                                            .failures = failures,
                                                            .feed = &feed,
                                                            .private_views = &private_views});
    const AcquisitionThread acquisition_thread({.source = **source,
                                                .ring = ring,
                                                .writer_bell = acquisition_bell,
                                                .counters = acquisition_counters,
                                                .ended_bell = server_bell,
                                                .feed = &feed},
                                               options.mismatch);
    acquisition = &acquisition_thread;
    fmt::print("Fanlight shows {} on {}\n", description.name,
               page_url((*server)->endpoint(), !options.tls.empty()));
    std::fflush(stdout);
    served = (*server)->run();
  }
  log_end(house, server_counters);
  return served;
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
  command->add_option("--listen", options->listen, "Address and port; port 0 takes a free one")
      ->capture_default_str()
      ->type_name("ADDR:PORT");
  auto* const certificate = command
                                ->add_option("--tls-certificate", options->tls.certificate,
                                             "The server's, and those up to its root, PEM")
                                ->type_name("FILE");
  auto* const key =
      command->add_option("--tls-key", options->tls.key, "Its private key, PEM")->type_name("FILE");
  certificate->needs(key);
  key->needs(certificate);
  command->add_option("--client-ca", options->tls.client_ca, "Who signs clients' certificates, PEM")
      ->needs(certificate)
      ->type_name("FILE");
  command
      ->add_option("--tokens", options->tokens,
                   "Who may come in, as `fanlight token` writes it; read again where it changes")
      ->type_name("FILE");
  command->add_option("--audit-log", options->audit_log, "Appends who changed what, a line of JSON each")
      ->type_name("FILE");
  command
      ->add_option("--control-lapse", options->control_lapse_s,
                   "The control is free again after so much silence")
      ->capture_default_str()
      ->check(CLI::Range(1, 86400))
      ->type_name("S");
  command
      ->add_option("--private-views", options->private_views,
                   "Displays that may have a light or a camera of their own at once")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{0}, kMostPrivateViews))
      ->type_name("N");
  command->add_option("--geometry", options->geometry_path, "TOML file with the recording's geometry")
      ->type_name("FILE");
  add_named_option<ReplaySource::Ending, ReplaySource::Ending>(
      *command, "--ending", options->playing.ending,
      {{"once", ReplaySource::Ending::kOnce},
       {"loop", ReplaySource::Ending::kLoop},
       {"to-and-fro", ReplaySource::Ending::kToAndFro}},
      "After the recording's last frame: once, loop or to-and-fro (the default)");
  command->add_option("--speed", options->playing.speed, "Of the recording: 1 as recorded, 0.01 to 1000")
      ->type_name("FACTOR");
  command->add_flag("--fast", options->playing.as_fast_as_taken,
                    "Play as fast as volumes are rendered, and render them all");
  command->add_option("--size", options->size, "Of the picture, pixels")
      ->capture_default_str()
      ->type_name("WxH");
  command->add_option("--gpu", options->gpu, "Part of the name of the GPU to use")->type_name("NAME");
  command->add_option("--jpeg-quality", options->jpeg_quality, "1 to 100")
      ->capture_default_str()
      ->check(CLI::Range(1, 100))
      ->type_name("N");
  command->add_option("--ring", options->ring_slots, "Volumes that the ring holds, 3 to 64")
      ->capture_default_str()
      ->check(CLI::Range(3, 64))
      ->type_name("N");
  add_named_option<std::optional<RingPolicy>, RingPolicy>(
      *command, "--policy", options->policy,
      {{"newest-wins", RingPolicy::kNewestWins}, {"process-all", RingPolicy::kProcessAll}},
      "Where volumes come faster than they are rendered: newest-wins drops older ones, process-all makes the "
      "source wait (the default with --fast)");
  add_named_option<MismatchCorrection, MismatchCorrection>(
      *command, "--mismatch", options->mismatch,
      {{"corrected", MismatchCorrection::kOn}, {"as-measured", MismatchCorrection::kOff}},
      "Where forward and backward sweeps disagree: corrected (the default), or angles as-measured");
  add_probe_options(*command, options->playing);
  add_named_option<ProbeControl, ProbeControl>(
      *command, "--probe-control", options->probe_control,
      {{"everyone", ProbeControl::kEveryone}, {"nobody", ProbeControl::kNobody}},
      "Whether whoever is in control may set the probe: everyone (the default) or nobody");
  options->scene.add_to(*command);
  return [options]() { return serve(*options); };
}

}  // namespace fanlight
