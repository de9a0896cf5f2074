// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/offline_volumes.hpp"
#include "acquisition/open_source.hpp"
#include "acquisition/source/suggested_scene.hpp"
#include "proto/base/printable.hpp"
#include "renderer/render_once.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/cli/auto_view.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/picture_file.hpp"
#include "server/cli/picture_series.hpp"
#include "server/cli/probe_options.hpp"
#include "server/cli/progress_line.hpp"
#include "server/cli/recorded_pictures.hpp"
#include "server/cli/render_report.hpp"
#include "server/cli/scene_options.hpp"

namespace fanlight {

namespace {

constexpr std::uint64_t kMostSimulated = 9999;

struct RenderOptions {
  std::string input;
  SourceOptions playing{.as_fast_as_taken = true};
  RenderFiles files;
  std::optional<std::uint64_t> volume;  // absent: the first that the source gives
  bool all = false;
  std::optional<std::int64_t> count;  // of volumes, with `all`; absent: to the end of the source
  std::string size = "512x512";
  std::string gpu;
  bool json = false;
  bool recorded = false;
  AutoOptions automatic;
  SceneOptions scene;
};

struct RenderedVolumes {
  std::int64_t pictures = 0;
  std::uint64_t interpolated = 0;  ///< of them, of volumes with frames interpolated
};

void print_frames(const RenderOptions& options, const RenderedVolumes& rendered,
                  const AcquisitionCounters& counters, const std::vector<DroppedSweep>& dropped,
                  const std::vector<std::string>& notes) {
  std::uint64_t received = 0;
  std::uint64_t unused = 0;
  std::uint64_t missing = 0;
  counters.seq_lock.read([&] {
    received = counters.frames_received.value();
    unused = counters.frames_unused();
    missing = counters.frames_missing.value();
  });
  if (options.json) {
    const nlohmann::ordered_json report = {{"input", options.input},
                                           {"pictures", rendered.pictures},
                                           {"volumes_interpolated", rendered.interpolated},
                                           {"frames_received", received},
                                           {"frames_unused", unused},
                                           {"frames_missing", missing},
                                           {"sweeps_dropped", dropped.size()},
                                           {"dropped", dropped_json(dropped)},
                                           {"notes", notes}};
    fmt::print("{}\n", json_text(report));
    return;
  }
  fmt::print("{} pictures of {}, {} of them of volumes with frames interpolated\n", rendered.pictures,
             options.input, rendered.interpolated);
  fmt::print("frames: {} received, {} of them in no volume, and {} that never came; sweeps dropped: {}\n",
             received, unused, missing, dropped.size());
  print_dropped(stdout, dropped);
  for (const std::string& note : notes) fmt::print("note: {}\n", note);
}

/// The renderer with what it needs.
struct RenderSetup {
  PictureSize size;
  RenderDevice device;
  RenderCounters counters;
  Scene suggested;  // for the source alone
  Scene scene;
  bool finds_view = false;  // by the first volume
  std::unique_ptr<Renderer> renderer;
  std::vector<std::string> notes;  // about the source, and what was chosen
  std::int64_t volumes = 0;        // that the source gives; 0: not known

  double pixel_mm() const { return viewport(scene, size).pixel_mm; }
};

/// Chooses the scene by this volume, where the user did not choose it.
Result<void> look_at(const RenderOptions& options, const Volume& volume, RenderSetup& setup) {
  if (!setup.finds_view) return {};
  const auto view = auto_view(volume, setup.suggested, options.scene, setup.size);
  if (!view) return view.error();
  setup.scene = view->scene;
  setup.renderer->show({.revision = 2, .scene = setup.scene});
  for (const std::string& choice : view->choices) setup.notes.push_back("auto: " + choice);
  setup.notes.push_back("auto: the same without it: " + view->options);
  return {};
}

/// Renders every volume of the source to numbered files, and prints what happened to its frames.
Result<void> render_all(const RenderOptions& options, OfflineVolumes& volumes, RenderSetup& setup) {
  if (!options.count && setup.volumes == 0) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} has no end, expected --count with --all", options.input)};
  }
  RenderedVolumes rendered;
  PictureSeries series(options.files);
  auto progress = std::make_optional<ProgressLine>();
  for (; !options.count || rendered.pictures < *options.count; ++rendered.pictures) {
    const auto volume = volumes.next();
    if (!volume) return volume.error();
    if (!*volume) break;
    (void)volumes.dropped();  // before its queue is full
    const std::uint64_t number = (*volume)->stamp().source_volume_index;
    if ((*volume)->stamp().frames_missing > 0) ++rendered.interpolated;
    if (rendered.pictures == 0) {
      if (auto chosen = look_at(options, **volume, setup); !chosen) return chosen;
    }
    const auto picture = render_once(*setup.renderer, **volume);
    if (!picture) return picture.error();
    if (auto written = series.add(*picture, number, setup.notes); !written) return written;
    const RenderFiles files = series.numbered(number);
    if (!files.depth.empty() || !files.surface.empty()) {
      const auto depths = setup.renderer->read_depth();
      if (!depths) return depths.error();
      if (auto written = write_depth_and_surface(files, *picture, *depths, setup.pixel_mm()); !written)
        return written;
    }
    progress->tell_count(rendered.pictures + 1, options.count.value_or(setup.volumes), "pictures");
  }
  if (auto finished = series.finish(); !finished) return finished;
  progress.reset();
  print_frames(options, rendered, volumes.counters(), volumes.dropped(), setup.notes);
  if (rendered.pictures > 0) return {};
  return Error{ErrorCode::kNotFound, "the source has no volume that can be rendered, expected one at least"};
}

/// Renders one volume, writes its picture and its depth map, and prints the report.
Result<void> render_one(const RenderOptions& options, OfflineVolumes& volumes, RenderSetup& setup) {
  ProgressLine progress;
  progress.tell_step(options.volume ? fmt::format("reads frames until volume {} is whole", *options.volume)
                                    : "reads frames until a volume is whole");
  const auto volume = volumes.pick(options.volume);
  if (!volume) return volume.error();
  progress.tell_step("renders");
  if (auto chosen = look_at(options, **volume, setup); !chosen) return chosen;
  const auto picture = render_once(*setup.renderer, **volume);
  progress.clear();
  if (!picture) return picture.error();
  const auto depths = setup.renderer->read_depth();
  if (!depths) return depths.error();

  if (auto written = write_picture(options.files.picture, *picture, setup.notes); !written) return written;
  if (auto written = write_depth_and_surface(options.files, *picture, *depths, setup.pixel_mm()); !written)
    return written;
  RenderReport report = report_of(options.input, *picture, depths->smooth_mm);
  report.dropped = volumes.dropped();
  report.notes = setup.notes;
  report.device = setup.device.name();
  report.speckle_filter_left_out = setup.counters.volumes_unfiltered.value() > 0;
  // A picture on the standard output leaves the other one to the report.
  std::FILE* const out = options.files.picture == kStandardOutput ? stderr : stdout;
  if (options.json) {
    print_json(out, report);
  } else {
    print_text(out, report);
  }
  return {};
}

Result<void> set_up(const RenderOptions& options, const PictureSize& size, const SourceDescription& source,
                    RenderSetup& setup) {
  setup.size = size;
  setup.volumes = static_cast<std::int64_t>(source.volumes);
  setup.suggested = suggested_scene(source, size.height);
  const auto scene = options.scene.applied_to(setup.suggested);
  if (!scene) return scene.error();
  setup.scene = *scene;
  setup.finds_view = finds_view(options.automatic, options.scene, source);
  for (const std::string& note : source.notes) setup.notes.push_back(printable(note));
  auto device = open_device(options.gpu);
  if (!device) return device.error();
  setup.device = std::move(*device);
  auto renderer = Renderer::create({.size = size,
                                    .geometry = source.geometry,
                                    .first_angle_rad = source.first_angle_rad,
                                    .last_angle_rad = source.last_angle_rad,
                                    .frame_capacity = source.frames_per_volume,
                                    .usual_frames = source.usual_frames},
                                   {.gpu = *setup.device.gpu, .counters = setup.counters},
                                   {.revision = 1, .scene = setup.scene});
  if (!renderer) return renderer.error();
  setup.renderer = std::move(*renderer);
  return {};
}

Result<void> render(const RenderOptions& options) {
  if (options.recorded) {
    return render_recorded_pictures({.input = options.input,
                                     .playing = options.playing,
                                     .out = options.files.picture,
                                     .gpu = options.gpu,
                                     .json = options.json});
  }
  const auto size = parse_picture_size(options.size);
  if (!size) return size.error();
  if (auto named = check_files(options.files, *size); !named) return named;
  if (options.files.is_video() && !options.all)
    return Error{ErrorCode::kInvalidArgument, "a video shows many volumes, expected --all with it"};
  if (options.files.picture == kStandardOutput && options.all)
    return Error{ErrorCode::kInvalidArgument, "--all writes many pictures, expected a name and not -"};
  Doorbell bell;
  ProbeLink probe(bell, bell);
  auto source = open_source(options.input, options.playing, probe);
  if (!source) return source.error();
  if ((*source)->description().simulated && options.volume.value_or(0) > kMostSimulated) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("--volume {} of the simulated probe, expected 0 to {}: it makes all volumes before it",
                    *options.volume, kMostSimulated)};
  }
  RenderSetup setup;
  if (auto ready = set_up(options, *size, (*source)->description(), setup); !ready) return ready;
  OfflineVolumes volumes(**source);
  return options.all ? render_all(options, volumes, setup) : render_one(options, volumes, setup);
}

}  // namespace

Command add_render_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("render", "Renders one volume to a picture file");
  const auto options = std::make_shared<RenderOptions>();
  command->option_defaults()->group("Input and output");
  command
      ->add_option(
          "INPUT", options->input,
          "A recording (.igs.mha, .seq.nrrd, .vol, .dcm, a folder of pictures), a volume on a grid (.mha, "
          ".nrrd, .dcm), phantom: for the simulated probe, usb:VENDOR:PRODUCT[:SERIAL] for a probe, or "
          "igtl:HOST[:PORT] for a scanner by OpenIGTLink")
      ->required()
      ->type_name("INPUT");
  command
      ->add_option(
          "--out", options->files.picture,
          "The picture to write, such as x.png or x.exr; - for the standard output; with --all also a "
          "video, x.mp4")
      ->required()
      ->type_name("FILE");
  command->add_option("--depth", options->files.depth, "The filtered depth map to write, mm, such as z.exr")
      ->type_name("FILE");
  command
      ->add_option("--surface", options->files.surface,
                   "The surface to write as triangles in mm: x.ply with colours, or x.stl")
      ->type_name("FILE");
  command
      ->add_option("--volume", options->volume,
                   "Which volume, as the source numbers them; without it the first that can be rendered")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  command
      ->add_flag(
          "--all", options->all,
          "Render every volume, to files with its number: x.0000.png, x.0001.png, ...; or to one video")
      ->excludes("--volume");
  command
      ->add_flag(
          "--recorded", options->recorded,
          "Render the pictures that displays saw while a server recorded INPUT, pixel by pixel the same "
          "on the same GPU, to files with their numbers: x.000001.png, ...")
      ->excludes("--all", "--volume", "--depth", "--surface");
  command->add_option("--count", options->count, "With --all: how many volumes, for a source that never ends")
      ->check(CLI::PositiveNumber)
      ->needs("--all")
      ->type_name("N");
  command->add_option("--geometry", options->playing.geometry_path, "TOML file with the recording's geometry")
      ->type_name("FILE");
  command->option_defaults()->group("Picture");
  command->add_option("--size", options->size, "Of the picture, pixels")
      ->capture_default_str()
      ->type_name("WxH");
  command->add_option("--gpu", options->gpu, "Part of the name of the GPU to use")->type_name("NAME");
  options->automatic.add_to(*command);
  command->add_flag("--json", options->json, "Print the report as JSON")->group("Input and output");
  add_probe_options(*command, options->playing);
  options->scene.add_to(*command);
  return [options]() { return render(*options); };
}

}  // namespace fanlight
