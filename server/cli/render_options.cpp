// SPDX-License-Identifier: Apache-2.0
#include "server/cli/render_options.hpp"

#include <CLI/CLI.hpp>

namespace fanlight {

void RenderOptions::add_files_to(CLI::App& command) {
  command.option_defaults()->group("Input and output");
  command
      .add_option("--out", files.picture,
                  "Output picture, such as x.png or x.exr; - for standard output; with --all also a "
                  "video, x.mp4. Follows symbolic links")
      ->type_name("FILE");
  command
      .add_option("--depth", files.depth,
                  "Output file for the filtered depth map in mm, such as z.exr or z.tif")
      ->type_name("FILE");
  command
      .add_option("--surface", files.surface,
                  "Output file for the surface as triangles in mm: x.ply with colours, or x.stl")
      ->type_name("FILE");
  command.add_option("--volume", volume, "Number of the volume; default: the first that can be rendered")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  command
      .add_flag("--all", all,
                "Render every volume, to numbered files (x.0000.png, x.0001.png, ...) or to one video")
      ->excludes("--volume");
  command.add_option("--count", count, "Number of volumes to render with --all, for a source without end")
      ->check(CLI::PositiveNumber)
      ->needs("--all")
      ->type_name("N");
  command.add_option("--geometry", playing.geometry_path, "TOML file with the geometry of the recording")
      ->type_name("FILE");
}

void RenderOptions::add_picture_to(CLI::App& command) {
  command.option_defaults()->group("Picture");
  command.add_option("--size", size, "Size of the picture in pixels")
      ->capture_default_str()
      ->type_name("WxH");
  automatic.add_to(command);
}

}  // namespace fanlight
