// SPDX-License-Identifier: Apache-2.0
#include "server/cli/batch_sweep.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>

#include "acquisition/replay/igs_sequence.hpp"
#include "acquisition/replay/recording_geometry.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/base/clock.hpp"
#include "proto/base/file_replacement.hpp"
#include "proto/base/printable.hpp"
#include "proto/base/version.hpp"
#include "server/cli/input_renderer.hpp"
#include "server/cli/json_text.hpp"

namespace fanlight {

namespace {

std::string with_name(std::string pattern, const std::string& name) {
  constexpr std::string_view kName = "{name}";
  for (std::size_t at = pattern.find(kName); at != std::string::npos;
       at = pattern.find(kName, at + name.size()))
    pattern.replace(at, kName.size(), name);
  return pattern;
}

/// Whether the fault lies with the sweep: another try would end the same.
bool is_of_sweep(ErrorCode code) {
  return code == ErrorCode::kInvalidArgument || code == ErrorCode::kBadInput ||
         code == ErrorCode::kUnsupported || code == ErrorCode::kNotFound;
}

Result<std::vector<FileDigest>> digests_of_input(const BatchSweep& sweep, const RenderOptions& options) {
  std::vector<FileDigest> digests;
  if (sweep.is_simulated()) return digests;
  auto files = recording_files(options.input);
  if (!files) return files.error();
  std::error_code unknown;
  const std::filesystem::path geometry =
      options.playing.geometry_path.empty() ? sidecar(options.input) : options.playing.geometry_path;
  if (std::filesystem::exists(geometry, unknown)) files->push_back(geometry);
  for (const std::filesystem::path& file : *files) {
    auto digest = digest_of(file, file.filename().string());
    if (!digest) return digest.error();
    digests.push_back(*std::move(digest));
  }
  return digests;
}

Result<void> make_folder_of(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) return {};
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (!failure) return {};
  return Error{ErrorCode::kUnavailable,
               fmt::format("the folder of {} cannot be made ({}), expected one that may be written",
                           printable(path), failure.message())};
}

/// Renders, and fills in what came of it.
Result<void> render(const RenderOptions& options, BatchRun& run, BatchRecord& record) {
  for (const std::string* const path :
       {&options.files.picture, &options.files.depth, &options.files.surface}) {
    if (auto made = make_folder_of(*path); !made) return made;
  }
  auto created = InputRenderer::create(options, run.device);
  if (!created) return created.error();
  InputRenderer& renderer = **created;
  record.device = run.device.name();
  const auto note_volume = [&]() -> Result<void> {
    const auto report = renderer.report();
    if (!report) return report.error();
    record.volumes.push_back(figures_json(*report));
    return {};
  };
  if (!options.all) {
    if (auto rendered = renderer.pick(); !rendered) return rendered;
    if (auto noted = note_volume(); !noted) return noted;
  }
  while (options.all) {
    if (run.stopped()) return Error{ErrorCode::kStopped, "stopped, expected another run for what is left"};
    const auto rendered = renderer.next();
    if (!rendered) return rendered.error();
    if (!*rendered) break;
    if (auto noted = note_volume(); !noted) return noted;
  }
  if (auto finished = renderer.finish(); !finished) return finished;
  record.interpolated = renderer.interpolated();
  const FrameCounts frames = frame_counts(renderer.counters());
  record.frames_received = frames.received;
  record.frames_unused = frames.unused;
  record.frames_missing = frames.missing;
  record.dropped = dropped_json(renderer.dropped());
  record.notes = renderer.notes();
  if (renderer.pictures() == 0)
    return Error{ErrorCode::kNotFound,
                 "the source has no volume that can be rendered, expected one at least"};
  for (const std::string& path : renderer.written()) {
    auto digest = digest_of(path, std::filesystem::path(path).lexically_relative(run.folder).string());
    if (!digest) return digest.error();
    record.outputs.push_back(*std::move(digest));
  }
  return {};
}

}  // namespace

std::filesystem::path record_path(const std::filesystem::path& folder, const BatchSweep& sweep) {
  return folder / (sweep.name + ".json");
}

SweepOptions::SweepOptions(const BatchSweep& sweep) : sweep_(sweep), command_("", "render") {
  options_.add_files_to(command_);
  options_.add_picture_to(command_);
  options_.scene.add_to(command_);
}

Result<void> SweepOptions::read(const std::filesystem::path& folder) {
  const auto any = [](const std::string&, const std::string&) { return Result<void>(); };
  if (auto taken = apply_options(command_, sweep_.given, any, origins_); !taken) return taken;
  if (auto fit = check_together(command_, origins_); !fit) return fit;
  const auto bad = [this](const std::string& wrong) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("{}: {}", sweep_.from, wrong)};
  };
  options_.input = sweep_.source();
  std::filesystem::path& geometry = options_.playing.geometry_path;
  if (!geometry.empty()) geometry = sweep_.folder / geometry;
  if (options_.files.picture.empty()) options_.files.picture = "{name}.png";
  for (std::string* const pattern :
       {&options_.files.picture, &options_.files.depth, &options_.files.surface}) {
    if (pattern->empty()) continue;
    if (pattern->find("{name}") == std::string::npos)
      return bad(fmt::format("{} would be the same file for every sweep, expected {{name}} in it",
                             in_quotes(*pattern)));
    *pattern = (folder / with_name(*pattern, sweep_.name)).string();
  }
  // The scene's own values are checked without the recording.
  if (auto scene = options_.scene.applied_to({}); !scene) return bad(scene.error().message);
  return {};
}

nlohmann::ordered_json SweepOptions::json() const {
  nlohmann::json sorted = nlohmann::json::object();
  for (const auto& [name, origin] : origins_) {
    const auto given = std::ranges::find(sweep_.given, name, &ConfiguredOption::name);
    sorted[name] = given->value;
  }
  return sorted;
}

Result<SweepEnd> render_sweep(const BatchSweep& sweep, BatchRun& run, BatchRecord& record) {
  const std::int64_t begun_ns = now_ns();
  SweepOptions asked(sweep);
  if (auto read = asked.read(run.folder); !read) return read.error();
  record = {.version = version(), .input = sweep.input, .options = asked.json()};
  record.host = run.host;
  record.shard = run.shard;
  record.begun = fmt::format("{:%FT%TZ}", fmt::gmtime(std::time(nullptr)));
  const std::filesystem::path path = record_path(run.folder, sweep);
  auto inputs = digests_of_input(sweep, asked.options());
  Result<void> done = inputs ? Result<void>() : inputs.error();
  if (inputs) {
    record.inputs = *std::move(inputs);
    const auto before = read_record(path);
    const bool is_there = before && before->trouble.empty() && before->asks_the_same(record) &&
                          has_outputs(*before, run.folder);
    if (is_there) {
      record = *before;
      return SweepEnd::kThere;
    }
    // From here on the outputs are those of two requests, until all are written.
    std::error_code was_not_there;
    std::filesystem::remove(path, was_not_there);
    done = render(asked.options(), run, record);
  }
  if (!done && !is_of_sweep(done.error().code)) return done.error();
  if (!done) record.trouble = done.error().message;
  record.seconds = static_cast<double>(now_ns() - begun_ns) * 1e-9;
  if (auto made = make_folder_of(path.string()); !made) return made.error();
  if (auto written = replace_file(path, json_text(json_of(record), 1) + "\n"); !written)
    return written.error();
  return done ? SweepEnd::kRendered : SweepEnd::kFailed;
}

}  // namespace fanlight
