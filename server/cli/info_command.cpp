// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <memory>
#include <optional>

#include "acquisition/offline_volumes.hpp"
#include "acquisition/open_source.hpp"
#include "acquisition/replay/file_facts.hpp"
#include "acquisition/replay/recording.hpp"
#include "acquisition/source/suggested_scene.hpp"
#include "proto/base/printable.hpp"
#include "proto/model/scene.hpp"
#include "renderer/vulkan/gpu.hpp"
#include "server/cli/auto_view.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/frames_plot.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/measurement_report.hpp"
#include "server/cli/picture_file.hpp"
#include "server/cli/recording_report.hpp"
#include "server/cli/serve_report.hpp"
#include "server/cli/sweep_report.hpp"

namespace fanlight {

namespace {

struct InfoOptions {
  std::string file;
  std::string geometry_path;
  bool fields = false;
  bool automatic = false;
  bool json = false;
  bool writes_geometry = false;
  std::string frames_path;
  std::string plot_path;
};

const char* pass_name(FirstPass pass) {
  switch (pass) {
    case FirstPass::kPrepare:
      return "prepare";
    case FirstPass::kCast:
      return "cast";
    case FirstPass::kFilter:
      return "filter";
    case FirstPass::kLight:
      return "light";
    case FirstPass::kNone:
      return "none";
  }
  return "none";
}

nlohmann::ordered_json field_json(const SceneField& field) {
  nlohmann::ordered_json row = {{"name", field.name}, {"help", field.help}};
  const Scene scene;
  if (field.is_text()) {
    row["kind"] = "text";
    row["default"] = field.get_text(scene);
  } else if (!field.choices.empty()) {
    row["kind"] = "choice";
    row["choices"] = field.choices;
    row["default"] = field_text(scene, field);
  } else {
    row["kind"] = "number";
    row["unit"] = field.unit;
    row["minimum"] = field.minimum;
    row["maximum"] = field.maximum;
    row["step"] = field.step;
    row["default"] = field.get(scene);
  }
  row["first_pass"] = pass_name(field.first_pass);
  return row;
}

Result<void> show_fields(bool json) {
  if (json) {
    auto rows = nlohmann::ordered_json::array();
    for (const SceneField& field : scene_fields()) rows.push_back(field_json(field));
    fmt::print("{}\n", json_text(rows, 1));
    return {};
  }
  for (const SceneField& field : scene_fields()) {
    const std::string range = field.is_text() ? "text"
                              : field.choices.empty()
                                  ? fmt::format("{} to {} {}", field.minimum, field.maximum, field.unit)
                                  : fmt::format("{}", fmt::join(field.choices, ", "));
    fmt::print("{:<28} {:<40} {}\n", field.name, range, field.help);
  }
  return {};
}

Result<void> print_gpus(bool json) {
  const auto instance = GpuInstance::create({});
  if (!instance) return instance.error();
  const auto& candidates = (*instance)->candidates();
  if (json) {
    auto rows = nlohmann::ordered_json::array();
    for (const GpuCandidate& candidate : candidates) {
      rows.push_back({{"name", candidate.name},
                      {"kind", candidate.kind},
                      {"driver", candidate.driver},
                      {"serves", candidate.refusals.empty()},
                      {"refusals", candidate.refusals},
                      {"compute_queues", candidate.queues}});
    }
    fmt::print("{}\n", json_text(rows, 1));
    return {};
  }
  if (candidates.empty())
    fmt::print("No GPU was found, expected one with Vulkan 1.3 or the package mesa-vulkan-drivers.\n");
  bool chosen = false;
  for (const GpuCandidate& candidate : candidates) {
    fmt::print("{} ({}, {})\n", candidate.name, candidate.kind, candidate.driver);
    if (!candidate.refusals.empty()) {
      fmt::print("  would not serve: {}\n", fmt::join(candidate.refusals, "; "));
    } else {
      fmt::print("  would serve{}; compute queues: {}\n", chosen ? "" : " and is the one that is taken",
                 candidate.queues);
      chosen = true;
    }
  }
  return {};
}

const std::uint64_t kMostBytes = Recording::Config{}.max_bytes;

Result<void> write_pictures(const InfoOptions& options, const FileFacts* facts, Recording* recording) {
  if (!options.frames_path.empty()) {
    std::optional<FileFacts> looked;
    if (facts == nullptr) {
      auto found = look_into(options.file, kMostBytes);
      if (!found) return found.error();
      facts = &looked.emplace(*std::move(found));
    }
    if (auto written = write_picture(options.frames_path, frames_side_by_side(*facts), {}); !written)
      return written;
  }
  if (options.plot_path.empty() || recording == nullptr) return {};
  const auto picture = frames_in_space(*recording);
  if (!picture) return picture.error();
  return write_picture(options.plot_path, *picture, {});
}

/// The file cannot be played: prints what is there, what lacks and how to supply it.
Result<void> print_unplayable(const InfoOptions& options, const Error& why) {
  if (why.code == ErrorCode::kNotFound) return why;  // the geometry file that was asked for, too
  const auto facts = look_into(options.file, kMostBytes);
  if (!facts) return why;
  // A recording without geometry, or of frames that form no fan, is a finding; a damaged one is an error.
  const bool is_finding = why.code == ErrorCode::kUnsupported || !facts->no_fan.empty();
  const std::string name = printable(options.file);
  if (options.json) {
    fmt::print("{}\n", json_text(facts_json(*facts, name, why.message), 1));
  } else {
    fmt::print("{}", facts_text(*facts, name));
  }
  if (auto written = write_pictures(options, &*facts, nullptr); !written) return written;
  // A geometry helps nothing where the frames form no fan.
  const bool forms_no_fan = !facts->no_fan.empty() || facts->frames < 2;
  if (forms_no_fan && options.writes_geometry) return why;
  const std::string draft =
      geometry_draft(*facts, printable(std::filesystem::path(options.file).filename().string()));
  if (options.writes_geometry) {
    const auto written = write_geometry_draft(options.file, draft);
    if (!written) return written.error();
    fmt::print(stderr, "wrote {}: edit it, and look at it with fanlight info {} --plot plot.png\n",
               printable(written->string()), name);
    if (options.plot_path.empty()) return {};
    auto recording = Recording::open({.path = options.file, .pixels = Recording::Pixels::kFromFile});
    return recording ? write_pictures(options, &*facts, &*recording) : Result<void>(recording.error());
  }
  if (!options.json) {
    if (!forms_no_fan)
      fmt::print("\nA geometry to edit; --write-geometry writes it to {}.toml:\n\n{}\n", name, draft);
    if (is_finding) fmt::print("Not playable{}: {}.\n", forms_no_fan ? "" : " yet", why.message);
  }
  std::fflush(stdout);  // before an error
  return is_finding ? Result<void>() : Result<void>(why);
}

Result<void> print_recording(const InfoOptions& options) {
  // The header and one frame: the pixels may be gigabytes.
  auto recording = Recording::open(
      {.path = options.file, .geometry_path = options.geometry_path, .pixels = Recording::Pixels::kFromFile});
  if (!recording) return print_unplayable(options, recording.error());
  if (auto whole = recording->check_pixels(); !whole) return whole;
  if (options.writes_geometry) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{}: it has a geometry already, expected a recording without one",
                             printable(options.file))};
  }
  const auto sweeps = examine_sweeps(
      options.file, {.geometry_path = options.geometry_path, .pace = SourcePace::kAsFastAsTaken});
  if (!sweeps) {
    if (!options.json) fmt::print("{}", recording_text(*recording));
    std::fflush(stdout);  // before the error
    return sweeps.error();
  }
  if (options.json) {
    auto json = recording_json(*recording);
    add_sweeps(json, *sweeps);
    add_measurements(json, options.file);
    fmt::print("{}\n", json_text(json, 1));
  } else {
    fmt::print("{}{}{}", recording_text(*recording), sweep_text(*sweeps), measurement_lines(options.file));
  }
  return write_pictures(options, nullptr, &*recording);
}

Result<void> print_phantom(const InfoOptions& options) {
  Doorbell bell;
  ProbeLink probe(bell, bell);
  const auto source = open_source(options.file, {}, probe);
  if (!source) return source.error();
  const SourceDescription& description = (*source)->description();
  const std::string sentence = source_words(description);
  if (options.json) {
    fmt::print("{}\n", json_text({{"name", description.name}, {"description", sentence}}, 1));
  } else {
    fmt::print("{}.\n", sentence);
  }
  return {};
}

/// Prints the command that shows the surface of the recording's first volume.
Result<void> print_surface(const InfoOptions& options) {
  Doorbell bell;
  ProbeLink probe(bell, bell);
  auto source = open_source(
      options.file, {.geometry_path = options.geometry_path, .pace = SourcePace::kAsFastAsTaken}, probe);
  if (!source) return source.error();
  const SourceDescription& description = (*source)->description();
  OfflineVolumes volumes(**source);
  const auto volume = volumes.pick(std::nullopt);
  if (!volume) return volume.error();
  const Scene base = suggested_scene(description);
  const auto view = auto_view(**volume, base, SceneOptions(), PictureSize());
  if (!view) return view.error();
  for (const std::string& choice : view->choices) fmt::print("  auto: {}\n", choice);
  const std::string geometry =
      options.geometry_path.empty() ? "" : fmt::format("--geometry {} ", options.geometry_path);
  fmt::print("fanlight render {} {}--out picture.png {}\n", options.file, geometry, view->options);
  return {};
}

}  // namespace

Command add_info_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("info", "Print information about a recording or the GPUs");
  const auto options = std::make_shared<InfoOptions>();
  CLI::Option* const file =
      command
          ->add_option("FILE", options->file,
                       "A recording (.igs.mha, .seq.nrrd, .vol, .dcm, a folder of "
                       "pictures), a volume on a grid (.mha, .nrrd, .nii, .dcm) or phantom:; "
                       "without it, the GPUs")
          ->type_name("FILE");
  command->add_option("--geometry", options->geometry_path, "TOML file with the geometry of the recording")
      ->type_name("FILE");
  command
      ->add_flag("--auto", options->automatic,
                 "Find the surface in the first volume, and print the command that shows it")
      ->needs(file);
  command->add_flag("--fields", options->fields, "Print the table of all scene fields")->excludes(file);
  command->add_flag("--json", options->json, "Print JSON");
  command
      ->add_flag("--write-geometry", options->writes_geometry,
                 "Write a geometry to edit to FILE.toml, guessed from the frames")
      ->needs(file);
  command
      ->add_option("--frames", options->frames_path,
                   "Write the first and the middle frame as a picture, with the sector found in them")
      ->needs(file)
      ->type_name("PICTURE");
  command
      ->add_option("--plot", options->plot_path,
                   "Write a picture of the frames, placed in space by the geometry")
      ->needs(file)
      ->type_name("PICTURE");
  return [options]() {
    if (options->fields) return show_fields(options->json);
    if (options->file.empty()) return print_gpus(options->json);
    if (options->file.starts_with("phantom:") && !std::filesystem::exists(options->file)) {
      const bool asks_more = options->writes_geometry || !options->frames_path.empty() ||
                             !options->plot_path.empty() || !options->geometry_path.empty();
      if (asks_more || (options->json && options->automatic)) {
        return Result<void>(Error{ErrorCode::kInvalidArgument,
                                  "phantom: has no file, expected --json or --auto with it, or a recording"});
      }
      if (auto printed = print_phantom(*options); !printed || !options->automatic) return printed;
      return print_surface(*options);
    }
    const auto printed = print_recording(*options);
    return printed && options->automatic ? print_surface(*options) : printed;
  };
}

}  // namespace fanlight
