// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>

#include "proto/base/printable.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/input_renderer.hpp"
#include "server/cli/probe_options.hpp"
#include "server/cli/progress_line.hpp"

namespace fanlight {

namespace {

Result<void> export_page(const RenderOptions& options) {
  if (!options.files.is_page()) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("{} is no page, expected a name that ends with .html", printable(options.files.picture))};
  }
  RenderDevice device;
  const auto renderer = InputRenderer::create(options, device);
  if (!renderer) return renderer.error();
  InputRenderer& pages = **renderer;
  {
    ProgressLine progress;
    if (!options.all) {
      if (auto rendered = pages.pick(); !rendered) return rendered;
    }
    while (options.all) {
      const auto rendered = pages.next();
      if (!rendered) return rendered.error();
      if (!*rendered) break;
      progress.show_count(pages.pictures(), pages.expected(), "surfaces");
    }
  }
  if (pages.pictures() == 0)
    return Error{ErrorCode::kNotFound,
                 "the source has no volume that can be rendered, expected one at least"};
  if (auto finished = pages.finish(); !finished) return finished;
  fmt::print("{}: {} of {}\n", options.files.picture,
             pages.pictures() == 1 ? "a surface" : fmt::format("{} surfaces", pages.pictures()),
             printable(options.input));
  for (const std::string& note : pages.notes()) fmt::print("note: {}\n", note);
  return {};
}

}  // namespace

Command add_export_command(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("export", "Export surfaces to an HTML file that needs no server");
  const auto options = std::make_shared<RenderOptions>();
  options->exports = true;
  command->option_defaults()->group("Input and output");
  command
      ->add_option(
          "INPUT", options->input,
          "A recording, a volume on a grid, phantom: for the simulated probe, as for fanlight render")
      ->required()
      ->type_name("INPUT");
  command
      ->add_option("--out", options->files.picture,
                   "Output file, x.html: a page with the surface, whose light moves and that turns. Opens in "
                   "browsers with WebGL 2")
      ->required()
      ->type_name("FILE");
  command
      ->add_option("--title", options->files.title,
                   "Text above the picture; without it the page says nothing of the source")
      ->type_name("TEXT");
  command
      ->add_option("--volume", options->volume,
                   "Number of the volume; default: the first that can be rendered")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  command->add_flag("--all", options->all, "Export every volume, as a film")->excludes("--volume");
  command->add_option("--count", options->count, "Number of volumes to export with --all")
      ->check(CLI::PositiveNumber)
      ->needs("--all")
      ->type_name("N");
  command
      ->add_option("--geometry", options->playing.geometry_path,
                   "TOML file with the geometry of the recording")
      ->type_name("FILE");
  options->add_picture_to(*command);
  command->add_option("--gpu", options->gpu, "GPU to use, by a part of its name")->type_name("NAME");
  add_probe_options(*command, options->playing);
  options->scene.add_to(*command);
  return [options]() { return export_page(*options); };
}

}  // namespace fanlight
