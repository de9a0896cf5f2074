// SPDX-License-Identifier: Apache-2.0
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <ctime>
#include <memory>

#include "acquisition/offline_volumes.hpp"
#include "acquisition/open_source.hpp"
#include "acquisition/replay/recording.hpp"
#include "acquisition/source/suggested_scene.hpp"
#include "proto/base/printable.hpp"
#include "proto/model/scene.hpp"
#include "renderer/vulkan/gpu.hpp"
#include "server/cli/auto_view.hpp"
#include "server/cli/commands.hpp"

namespace fanlight {

namespace {

struct InfoOptions {
  std::string file;
  std::string geometry_path;
  bool fields = false;
  bool automatic = false;
  bool json = false;
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
    fmt::print("{}\n", rows.dump(1));
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

Result<void> tell_of_gpus() {
  const auto instance = GpuInstance::create({});
  if (!instance) return instance.error();
  const auto& candidates = (*instance)->candidates();
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

Result<void> tell_of_recording(const InfoOptions& options) {
  // The header and one frame: the pixels may be gigabytes.
  const auto recording = Recording::open(
      {.path = options.file, .geometry_path = options.geometry_path, .pixels = Recording::Pixels::kFromFile});
  if (!recording) return recording.error();
  const RecordingSummary& summary = recording->summary();
  fmt::print("{}\n", summary.name);
  fmt::print("  frames      {} of {} x {}, {}{}\n", summary.frames, summary.columns, summary.rows,
             summary.format.name(), summary.compressed ? ", compressed" : "");
  fmt::print("  invalid     {}, of them {} by their angle; lost while recording {}\n", summary.frames_invalid,
             summary.angle_outliers, summary.frames_lost);
  fmt::print("  sweeps      {}, the longest of {} frames\n", summary.sweeps, summary.frames_in_longest_sweep);
  fmt::print("  angles      {:.2f} to {:.2f} deg\n", summary.smallest_angle_deg, summary.largest_angle_deg);
  fmt::print("  time        {:.2f} s, {:.1f} frames a second\n", summary.duration_s, summary.frame_rate_hz);
  if (const RecordedStream* const stream = recording->stream()) {
    fmt::print("  recorded    {:%Y-%m-%d %H:%M:%S} UTC from {}\n",
               fmt::gmtime(static_cast<std::time_t>(stream->facts.begun_utc_s)),
               printable(stream->facts.source));
  }
  for (const RecordingGeometry::Value& value : summary.geometry_values) {
    fmt::print("  {:<23} {} (from {})\n", value.key, value.value, value.origin);
  }
  for (const std::string& note : summary.notes) fmt::print("  note: {}\n", note);
  return {};
}

/// Prints the command that shows the surface of the recording's first volume.
Result<void> tell_of_surface(const InfoOptions& options) {
  Doorbell bell;
  ProbeLink probe(bell, bell);
  auto source =
      open_source(options.file, {.geometry_path = options.geometry_path, .as_fast_as_taken = true}, probe);
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
  CLI::App* command = program.add_subcommand("info", "Tells of a recording, or of the GPUs of this machine");
  const auto options = std::make_shared<InfoOptions>();
  CLI::Option* const file = command->add_option(
      "FILE", options->file, "A recording (.igs.mha, .seq.nrrd, .vol); without it, the GPUs");
  command->add_option("--geometry", options->geometry_path, "TOML file with the recording's geometry");
  command
      ->add_flag("--auto", options->automatic,
                 "Find the surface in the first volume, and print the command that shows it")
      ->needs(file);
  CLI::Option* const fields =
      command->add_flag("--fields", options->fields, "The table of all scene fields")->excludes(file);
  command->add_flag("--json", options->json, "The table of fields as JSON")->needs(fields);
  return [options]() {
    if (options->fields) return show_fields(options->json);
    if (options->file.empty()) return tell_of_gpus();
    const auto told = tell_of_recording(*options);
    return told && options->automatic ? tell_of_surface(*options) : told;
  };
}

}  // namespace fanlight
