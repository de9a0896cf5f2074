#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/open_source.hpp"
#include "renderer/renderer.hpp"
#include "server/commands.hpp"
#include "server/picture_file.hpp"
#include "server/probe_options.hpp"
#include "server/scene_options.hpp"
#include "server/volume_picker.hpp"

namespace fanlight {

namespace {

struct RenderOptions {
  std::string input;
  SourceOptions playing;
  std::string geometry_path;
  std::string out;
  std::string depth;
  std::int64_t volume = 0;
  bool all = false;
  std::optional<std::int64_t> count;  // of volumes, with `all`; absent: to the end of the source
  std::string size = "512x512";
  std::string gpu;
  bool json = false;
  SceneOptions scene;
};

Result<Picture> render_once(Renderer& renderer, const Volume& volume) {
  if (auto loaded = renderer.load(volume); !loaded) return loaded.error();
  Picture picture;
  for (;;) {
    if (auto advanced = renderer.advance(); !advanced) return advanced.error();
    if (renderer.collect(picture)) return picture;
    constexpr std::int64_t kSecondNs = 1'000'000'000;
    if (auto waited = renderer.wait(kSecondNs); !waited) return waited.error();
  }
}

/// The depths of the surface that stand at these shares of all, in mm; empty without a surface.
std::vector<float> depth_quantiles_mm(const std::vector<float>& smooth_mm, std::span<const double> shares) {
  std::vector<float> depths_mm;
  std::ranges::copy_if(smooth_mm, std::back_inserter(depths_mm), [](float depth) { return depth >= 0; });
  if (depths_mm.empty()) return {};
  std::ranges::sort(depths_mm);
  std::vector<float> quantiles_mm;
  for (const double share : shares) {
    quantiles_mm.push_back(
        depths_mm[static_cast<std::size_t>(share * static_cast<double>(depths_mm.size() - 1))]);
  }
  return quantiles_mm;
}

void print_report(const RenderOptions& options, const Picture& picture, const DepthMaps& depths,
                  bool speckle_filter_left_out, const std::string& device) {
  const auto surfaces = std::ranges::count_if(depths.smooth_mm, [](float depth) { return depth >= 0; });
  const double share = static_cast<double>(surfaces) / static_cast<double>(depths.smooth_mm.size());
  constexpr double kShares[] = {0.05, 0.5, 0.95};
  const auto quantiles_mm = depth_quantiles_mm(depths.smooth_mm, kShares);
  double total_ms = 0;
  for (const double stage_ms : picture.stamp.stage_ms) total_ms += stage_ms;

  if (options.json) {
    nlohmann::ordered_json stages;
    for (std::size_t stage = 0; stage < kStages; ++stage) {
      stages[std::string(kStageNames[stage])] = picture.stamp.stage_ms[stage];
    }
    const nlohmann::ordered_json report = {{"input", options.input},
                                           {"volume", options.volume},
                                           {"frames", picture.stamp.volume.frames},
                                           {"device", device},
                                           {"width", picture.width},
                                           {"height", picture.height},
                                           {"surface_share", share},
                                           {"depth_5_50_95_mm", quantiles_mm},
                                           {"speckle_filter_left_out", speckle_filter_left_out},
                                           {"stage_ms", stages},
                                           {"total_ms", total_ms}};
    fmt::print("{}\n", report.dump());
    return;
  }
  fmt::print("volume {} of {}: {} frames, {} x {} pixels on {}, a surface in {:.1f} % of them\n",
             options.volume, options.input, picture.stamp.volume.frames, picture.width, picture.height,
             device, 100 * share);
  if (speckle_filter_left_out) {
    fmt::print("the speckle filter was left out: the volume is too large for it on this GPU\n");
  }
  if (!quantiles_mm.empty()) {
    fmt::print(
        "its depth below the view plane: {:.1f} mm at the median, 5 % before {:.1f}, 5 % beyond {:.1f}\n",
        quantiles_mm[1], quantiles_mm[0], quantiles_mm[2]);
  }
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    fmt::print("  {:<10} {:8.2f} ms\n", kStageNames[stage], picture.stamp.stage_ms[stage]);
  }
  fmt::print("  {:<10} {:8.2f} ms\n", "together", total_ms);
}

/// x.png -> x.0007.png
std::string numbered(const std::string& path, std::int64_t number) {
  const std::filesystem::path whole(path);
  return (whole.parent_path() / whole.stem()).string() + fmt::format(".{:04}", number) +
         whole.extension().string();
}

/// Renders every volume of the source, and says what became of its frames.
Result<void> render_all(const RenderOptions& options, VolumePicker& picker, Renderer& renderer) {
  std::int64_t rendered = 0;
  std::uint64_t interpolated = 0;
  for (; !options.count || rendered < *options.count; ++rendered) {
    const auto volume = picker.next();
    if (!volume) return volume.error();
    if (!*volume) break;
    if ((*volume)->stamp().frames_missing > 0) ++interpolated;
    const auto picture = render_once(renderer, **volume);
    if (!picture) return picture.error();
    if (auto written = write_picture(numbered(options.out, rendered), *picture); !written) return written;
  }
  const AcquisitionCounters& frames = picker.counters();
  std::uint64_t received = 0;
  std::uint64_t unused = 0;
  std::uint64_t missing = 0;
  frames.ledger.read([&] {
    received = frames.frames_received.value();
    unused = frames.frames_unused();
    missing = frames.frames_missing.value();
  });
  const std::uint64_t sweeps_dropped = frames.volumes_incomplete.value() + frames.volumes_short.value();
  if (options.json) {
    const nlohmann::ordered_json report = {
        {"input", options.input},          {"pictures", rendered},    {"volumes_interpolated", interpolated},
        {"frames_received", received},     {"frames_unused", unused}, {"frames_missing", missing},
        {"sweeps_dropped", sweeps_dropped}};
    fmt::print("{}\n", report.dump());
  } else {
    fmt::print("{} pictures of {}, {} of them of volumes with frames interpolated\n", rendered, options.input,
               interpolated);
    fmt::print("frames: {} received, {} of them in no volume, and {} that never came; sweeps dropped: {}\n",
               received, unused, missing, sweeps_dropped);
  }
  if (rendered > 0) return {};
  return Error{ErrorCode::kNotFound, "the source has no volume that can be rendered, expected one at least"};
}

Result<void> render(const RenderOptions& options) {
  const auto size = parse_picture_size(options.size);
  if (!size) return size.error();
  if (auto named = check_depth_path(options.depth); !named) return named;
  if (options.all && !options.depth.empty()) {
    return Error{ErrorCode::kInvalidArgument, "--depth goes with one volume, expected it without --all"};
  }
  SourceOptions playing = options.playing;
  playing.geometry_path = options.geometry_path;
  playing.as_fast_as_taken = true;
  Doorbell bell;
  ProbeLink probe(bell, bell);
  auto source = open_source(options.input, playing, probe);
  if (!source) return source.error();
  const SourceDescription& description = (*source)->description();
  const auto scene = options.scene.applied_to(
      scene_for(description.geometry, description.first_angle_rad, description.last_angle_rad, size->height));
  if (!scene) return scene.error();

  const auto instance = GpuInstance::create({});
  if (!instance) return instance.error();
  const auto gpu = Gpu::create(**instance, options.gpu);
  if (!gpu) return gpu.error();
  RenderCounters counters;
  const auto renderer =
      Renderer::create({.size = *size,
                        .geometry = description.geometry,
                        .first_angle_rad = description.first_angle_rad,
                        .last_angle_rad = description.last_angle_rad,
                        .frame_capacity = description.frames_per_volume,
                        .usual_frames = description.usual_frames},
                       {.gpu = **gpu, .counters = counters}, {.revision = 1, .scene = *scene});
  if (!renderer) return renderer.error();

  VolumePicker picker(**source);
  if (options.all) return render_all(options, picker, **renderer);
  const auto volume = picker.pick(options.volume);
  if (!volume) return volume.error();
  const auto picture = render_once(**renderer, **volume);
  if (!picture) return picture.error();
  const auto depths = (*renderer)->read_depth();
  if (!depths) return depths.error();

  if (auto written = write_picture(options.out, *picture); !written) return written;
  if (!options.depth.empty()) {
    const double pixel = viewport(*scene, *size).pixel_mm;
    if (auto written = write_depth(options.depth, depths->smooth_mm, size->width, size->height, pixel);
        !written) {
      return written;
    }
  }
  print_report(options, *picture, *depths, counters.volumes_unfiltered.value() > 0, (*gpu)->candidate().name);
  return {};
}

}  // namespace

Command add_render_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("render", "Renders one volume to a picture file");
  const auto options = std::make_shared<RenderOptions>();
  command
      ->add_option("INPUT", options->input,
                   "A recording (.igs.mha), phantom: for the simulated probe, or usb:VENDOR:PRODUCT[:SERIAL] "
                   "for a probe")
      ->required();
  command->add_option("--out", options->out, "The picture to write, such as x.png")
      ->required()
      ->type_name("FILE");
  command->add_option("--depth", options->depth, "The filtered depth map to write, mm, such as z.exr")
      ->type_name("FILE");
  command->add_option("--volume", options->volume, "Which volume of the source, from 0")
      ->check(CLI::Range(0, 9999))  // the phantom has one for every number, and makes all those before it
      ->type_name("N");
  command->add_flag("--all", options->all,
                    "Render every volume, to numbered files: x.0000.png, x.0001.png, ...");
  command->add_option("--count", options->count, "With --all: how many volumes, for a source that never ends")
      ->check(CLI::PositiveNumber)
      ->needs("--all")
      ->type_name("N");
  command->add_option("--geometry", options->geometry_path, "TOML file with the recording's geometry")
      ->type_name("FILE");
  command->add_option("--size", options->size, "Of the picture, pixels")
      ->capture_default_str()
      ->type_name("WxH");
  command->add_option("--gpu", options->gpu, "Part of the name of the GPU to use")->type_name("NAME");
  command->add_flag("--json", options->json, "Print the report as JSON");
  add_probe_options(*command, options->playing);
  options->scene.add_to(*command);
  return [options]() { return render(*options); };
}

}  // namespace fanlight
