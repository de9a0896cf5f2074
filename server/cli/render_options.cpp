// SPDX-License-Identifier: Apache-2.0
#include "server/cli/render_options.hpp"

#include <CLI/CLI.hpp>

namespace fanlight {

void RenderOptions::add_files_to(CLI::App& command) {
  command.option_defaults()->group("Input and output");
  command
      .add_option(
          "--out", files.picture,
          "The picture to write, such as x.png or x.exr; - for the standard output; with --all also a "
          "video, x.mp4")
      ->type_name("FILE");
  command.add_option("--depth", files.depth, "The filtered depth map to write, mm, such as z.exr")
      ->type_name("FILE");
  command
      .add_option("--surface", files.surface,
                  "The surface to write as triangles in mm: x.ply with colours, or x.stl")
      ->type_name("FILE");
  command
      .add_option("--volume", volume,
                  "Which volume, as the source numbers them; without it the first that can be rendered")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  command
      .add_flag("--all", all,
                "Render every volume, to files with its number: x.0000.png, x.0001.png, ...; or to one video")
      ->excludes("--volume");
  command.add_option("--count", count, "With --all: how many volumes, for a source that never ends")
      ->check(CLI::PositiveNumber)
      ->needs("--all")
      ->type_name("N");
  command.add_option("--geometry", playing.geometry_path, "TOML file with the recording's geometry")
      ->type_name("FILE");
}

void RenderOptions::add_picture_to(CLI::App& command) {
  command.option_defaults()->group("Picture");
  command.add_option("--size", size, "Of the picture, pixels")->capture_default_str()->type_name("WxH");
  automatic.add_to(command);
}

}  // namespace fanlight
