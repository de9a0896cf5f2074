// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "server/cli/commands.hpp"
#include "server/cli/input_renderer.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/picture_file.hpp"
#include "server/cli/probe_options.hpp"
#include "server/cli/progress_line.hpp"
#include "server/cli/recorded_pictures.hpp"
#include "server/cli/sweep_report.hpp"

namespace fanlight {

namespace {

struct RenderCommandOptions : RenderOptions {
  bool json = false;
  bool recorded = false;
};

void print_frames(const RenderCommandOptions& options, InputRenderer& rendered) {
  const FrameCounts frames = frame_counts(rendered.counters());
  const std::vector<DroppedSweep>& dropped = rendered.dropped();
  if (options.json) {
    const nlohmann::ordered_json report = {{"input", options.input},
                                           {"pictures", rendered.pictures()},
                                           {"volumes_interpolated", rendered.interpolated()},
                                           {"frames_received", frames.received},
                                           {"frames_unused", frames.unused},
                                           {"frames_missing", frames.missing},
                                           {"sweeps_dropped", dropped.size()},
                                           {"dropped", dropped_json(dropped)},
                                           {"notes", rendered.notes()},
                                           {"warnings", warnings_json(rendered.warned())}};
    fmt::print("{}\n", json_text(report));
    return;
  }
  fmt::print("{} pictures of {}, {} of them of volumes with frames interpolated\n", rendered.pictures(),
             options.input, rendered.interpolated());
  fmt::print("frames: {} received, {} of them in no volume, {} missing; sweeps dropped: {}\n",
             frames.received, frames.unused, frames.missing, dropped.size());
  print_dropped(stdout, dropped);
  for (const std::string& note : rendered.notes()) fmt::print("note: {}\n", note);
  fmt::print("{}", warnings_text(rendered.warned(), rendered.pictures()));
}

/// Renders every volume of the source to numbered files, and prints what happened to its frames.
Result<void> render_all(const RenderCommandOptions& options, InputRenderer& renderer) {
  auto progress = std::make_optional<ProgressLine>();
  for (;;) {
    const auto rendered = renderer.next();
    if (!rendered) return rendered.error();
    if (!*rendered) break;
    progress->show_count(renderer.pictures(), renderer.expected(), "pictures");
  }
  if (auto finished = renderer.finish(); !finished) return finished;
  progress.reset();
  print_frames(options, renderer);
  if (renderer.pictures() > 0) return {};
  return Error{ErrorCode::kNotFound, "the source has no volume that can be rendered, expected one at least"};
}

/// Renders one volume, writes its picture and its depth map, and prints the report.
Result<void> render_one(const RenderCommandOptions& options, InputRenderer& renderer) {
  {
    ProgressLine progress;
    progress.show_step(options.volume
                           ? fmt::format("reading frames until volume {} is complete", *options.volume)
                           : "reading frames until a volume is complete");
    if (auto rendered = renderer.pick(); !rendered) return rendered;
  }
  auto report = renderer.report();
  if (!report) return report.error();
  report->dropped = renderer.dropped();
  // A picture on the standard output leaves the other one to the report.
  std::FILE* const out = options.files.picture == kStandardOutput ? stderr : stdout;
  if (options.json) {
    print_json(out, *report);
  } else {
    print_text(out, *report);
  }
  return {};
}

Result<void> render(const RenderCommandOptions& options) {
  if (options.recorded) {
    return render_recorded_pictures({.input = options.input,
                                     .playing = options.playing,
                                     .out = options.files.picture,
                                     .gpu = options.gpu,
                                     .json = options.json});
  }
  RenderDevice device;
  const auto renderer = InputRenderer::create(options, device);
  if (!renderer) return renderer.error();
  return options.all ? render_all(options, **renderer) : render_one(options, **renderer);
}

}  // namespace

Command add_render_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("render", "Render a volume to a picture file");
  const auto options = std::make_shared<RenderCommandOptions>();
  command->option_defaults()->group("Input and output");
  command
      ->add_option(
          "INPUT", options->input,
          "A recording (.igs.mha, .seq.nrrd, .vol, .dcm, a folder of pictures), a volume on a grid (.mha, "
          ".nrrd, .nii, .dcm), phantom: for the simulated probe, usb:VENDOR:PRODUCT[:SERIAL] for a probe, or "
          "igtl:HOST[:PORT] for a scanner by OpenIGTLink")
      ->required()
      ->type_name("INPUT");
  options->add_files_to(*command);
  command->get_option("--out")->required();
  command
      ->add_flag(
          "--recorded", options->recorded,
          "Render the pictures that displays showed while a server recorded INPUT, identical pixel by pixel "
          "on the same GPU, to numbered files: x.000001.png, ...")
      ->excludes("--all", "--volume", "--depth", "--surface");
  options->add_picture_to(*command);
  command->add_option("--gpu", options->gpu, "GPU to use, by a part of its name")->type_name("NAME");
  command->add_flag("--json", options->json, "Print the report as JSON")->group("Input and output");
  add_probe_options(*command, options->playing);
  options->scene.add_to(*command);
  return [options]() { return render(*options); };
}

}  // namespace fanlight
