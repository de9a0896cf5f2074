// SPDX-License-Identifier: Apache-2.0
#include "server/cli/batch_sweep.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <ctime>

#include "acquisition/replay/image_series.hpp"
#include "acquisition/replay/recording_file.hpp"
#include "acquisition/sequence/recording_geometry.hpp"
#include "acquisition/source/printable.hpp"
#include "proto/base/clock.hpp"
#include "proto/base/file_replacement.hpp"
#include "proto/base/folder_beneath.hpp"
#include "proto/base/printable.hpp"
#include "proto/base/version.hpp"
#include "server/cli/input_renderer.hpp"
#include "server/cli/json_text.hpp"
#include "server/cli/picture_file.hpp"
#include "server/codec/surface_mesh.hpp"

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

/// An error that another machine, or another try, may not have.
Error machine_trouble(BatchRun& run, const Error& error) {
  run.is_in_trouble = true;
  return {ErrorCode::kUnavailable, error.message};
}

/// Of a file beneath the folder of the outputs, which is made too.
Result<void> make_folder_of(const std::string& path, const std::filesystem::path& outputs) {
  std::error_code failure;
  std::filesystem::create_directories(outputs, failure);
  FolderBeneath folder;
  int wrong = failure ? failure.value() : folder.open(outputs, path, FolderBeneath::Missing::kMake);
  if (wrong == 0 && access(folder.name().parent_path().c_str(), W_OK | X_OK) != 0) wrong = errno;
  if (wrong == 0) return {};
  return Error{ErrorCode::kUnavailable,
               fmt::format("the folder of {} cannot be written ({}), expected one that may be",
                           printable(path), write_failure(wrong))};
}

Result<void> make_folders(const RenderFiles& files) {
  for (const std::string* const path : {&files.picture, &files.depth, &files.surface}) {
    if (path->empty()) continue;
    if (auto made = make_folder_of(*path, files.beneath); !made) return made;
  }
  return {};
}

/// Removes a file beneath the folder of the outputs, where it is.
void remove_output(const std::filesystem::path& path, const std::filesystem::path& outputs) {
  FolderBeneath folder;
  if (folder.open(outputs, path, FolderBeneath::Missing::kFail) != 0) return;
  std::error_code was_not_there;
  std::filesystem::remove(folder.name(), was_not_there);
}

/// Refuses outputs that would take the place of what is rendered.
Result<void> check_apart(const RenderFiles& files, const std::vector<std::filesystem::path>& inputs,
                         bool series) {
  for (const std::string* const path : {&files.picture, &files.depth, &files.surface}) {
    if (path->empty()) continue;
    const std::filesystem::path output(*path);
    for (const std::filesystem::path& input : inputs) {
      std::error_code not_there;
      const bool same_file = std::filesystem::equivalent(output, input, not_there);
      const bool same_folder =
          series && std::filesystem::equivalent(output.parent_path(), input.parent_path(), not_there);
      if (same_file || same_folder)
        return Error{ErrorCode::kInvalidArgument,
                     fmt::format("{} would lie among the files of the recording, expected another folder",
                                 printable(*path))};
    }
  }
  return {};
}

/// What a record of before names. It may be of other options, and leave files that this request does not
/// have.
void remove_outputs(const BatchRecord& record, const std::filesystem::path& folder) {
  for (const FileDigest& output : record.outputs) {
    if (stays_inside(output.file)) remove_output(folder / output.file, folder);
  }
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
  const bool is_series = ImageSeries::is_series(options.input);
  if (auto apart = check_apart(options.files, *files, is_series); !apart) return apart.error();
  for (const std::filesystem::path& file : *files) {
    auto digest = digest_of(file, file.filename().string());
    if (!digest) return digest.error();
    digests.push_back(*std::move(digest));
  }
  return digests;
}

/// The counts of a source that was read to its end; else those of the volumes alone, since it is not known
/// how far it was read ahead.
void count_frames(InputRenderer& renderer, bool to_the_end, BatchRecord& record) {
  if (!to_the_end) return;
  const FrameCounts frames = frame_counts(renderer.counters());
  record.frames_received = frames.received;
  record.frames_unused = frames.unused;
  record.frames_missing = frames.missing;
  record.dropped = dropped_json(renderer.dropped());
}

Result<void> render_volumes(const RenderOptions& options, BatchRun& run, InputRenderer& renderer,
                            BatchRecord& record) {
  for (bool more = true; more;) {
    if (run.stopped()) return Error{ErrorCode::kStopped, "stopped, expected another run for what is left"};
    if (options.all) {
      const auto rendered = renderer.next();
      if (!rendered) return rendered.error();
      if (!*rendered) break;
    } else if (auto rendered = renderer.pick(); !rendered) {
      return rendered;
    }
    more = options.all;
    const auto report = renderer.report();
    if (!report) return report.error();
    record.volumes.push_back(figures_json(*report));
    record.frames_received += renderer.picture().stamp.volume.frames;
    record.frames_missing += renderer.picture().stamp.volume.frames_missing;
  }
  if (auto finished = renderer.finish(); !finished) return finished;
  if (renderer.pictures() > 0) return {};
  return Error{ErrorCode::kNotFound, "the source has no volume that can be rendered, expected one at least"};
}

/// Renders, and fills in what came of it.
Result<void> render(const RenderOptions& options, BatchRun& run, BatchRecord& record) {
  if (auto made = make_folders(options.files); !made) return machine_trouble(run, made.error());
  if (!run.device.gpu) {
    auto opened = open_device(run.gpu);
    if (!opened) return machine_trouble(run, opened.error());
    run.device = *std::move(opened);
  }
  auto created = InputRenderer::create(options, run.device, &run.pipelines);
  if (!created) return created.error();
  InputRenderer& renderer = **created;
  record.device = run.device.name();
  if (auto rendered = render_volumes(options, run, renderer, record); !rendered) {
    for (const std::string& path : renderer.written()) remove_output(path, run.folder);
    record.volumes = nlohmann::ordered_json::array();
    record.frames_received = record.frames_missing = 0;
    return rendered;
  }
  record.interpolated = renderer.interpolated();
  record.notes = renderer.notes();
  count_frames(renderer, options.all && !options.count, record);
  for (const std::string& path : renderer.written()) {
    auto digest = digest_of(path, std::filesystem::path(path).lexically_relative(run.folder).string());
    if (!digest) return machine_trouble(run, digest.error());
    record.outputs.push_back(*std::move(digest));
  }
  return {};
}

/// What check_render() checks, but for the folders, which are made when a sweep is rendered.
Result<void> check_forms(const RenderOptions& options) {
  const RenderFiles& files = options.files;
  if (auto size = parse_picture_size(options.size); !size) return size.error();
  if (auto good = check_picture_ending(files.picture); !good && !files.is_video()) return good;
  if (auto good = check_depth_path(files.depth); !good) return good;
  if (auto good = check_mesh_path(files.surface); !good) return good;
  if (files.is_video() && !options.all)
    return Error{ErrorCode::kInvalidArgument, "a video shows many volumes, expected all = true with it"};
  if (files.picture == files.depth || files.picture == files.surface)
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("{} would be two outputs, expected two names", printable(files.picture))};
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
    *pattern = with_name(*pattern, sweep_.name);
    if (!stays_inside(*pattern))
      return bad(
          fmt::format("{} does not stay in the folder of the outputs, expected a name such as {{name}}.png",
                      in_quotes(*pattern)));
    *pattern = (folder / *pattern).string();
  }
  options_.files.beneath = folder;
  if (auto good = check_forms(options_); !good) return bad(good.error().message);
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
  const auto before = read_record(path);
  auto inputs = digests_of_input(sweep, asked.options());
  if (!inputs && !is_of_sweep(inputs.error().code)) return inputs.error();
  if (!inputs && before && before->trouble.empty() && before->version == record.version &&
      before->input == record.input && before->options == record.options) {
    // An archive that is not there for a moment is no reason to lose what came of it.
    return Error{ErrorCode::kUnavailable,
                 fmt::format("{}; its outputs of before are kept", inputs.error().message)};
  }
  Result<void> done = inputs ? Result<void>() : inputs.error();
  if (inputs) {
    record.inputs = *std::move(inputs);
    const bool is_there = before && before->trouble.empty() && before->asks_the_same(record) &&
                          has_outputs(*before, run.folder);
    if (is_there) {
      record = *before;
      return SweepEnd::kThere;
    }
    // From here on the outputs are those of two requests, until all are written.
    if (before) remove_outputs(*before, run.folder);
    remove_output(path, run.folder);
    done = render(asked.options(), run, record);
  }
  if (!done && !is_of_sweep(done.error().code)) return done.error();
  if (!done) record.trouble = done.error().message;
  record.seconds = static_cast<double>(now_ns() - begun_ns) * 1e-9;
  if (auto made = make_folder_of(path.string(), run.folder); !made) return machine_trouble(run, made.error());
  if (auto written = replace_file(path, json_text(json_of(record), 1) + "\n", {.beneath = run.folder});
      !written)
    return machine_trouble(run, written.error());
  return done ? SweepEnd::kRendered : SweepEnd::kFailed;
}

}  // namespace fanlight
