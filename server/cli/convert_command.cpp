// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <optional>
#include <string>

#include "acquisition/convert/converted_files.hpp"
#include "acquisition/convert/dicom_volume.hpp"
#include "acquisition/offline_volumes.hpp"
#include "acquisition/open_source.hpp"
#include "proto/base/printable.hpp"
#include "server/cli/commands.hpp"
#include "server/cli/progress_line.hpp"
#include "server/pacs/identity_json.hpp"

namespace fanlight {

namespace {

struct ConvertOptions {
  std::string input;
  std::string out;
  std::string geometry_path;
  std::string patient;
  std::optional<std::uint64_t> volume;
  std::optional<double> spacing_mm;
};

Result<void> write_grid(const std::string& out, const GridVolume& grid, const DicomSource& source) {
  if (out.ends_with(".nrrd")) return write_grid_nrrd(out, grid);
  if (out.ends_with(".dcm")) return write_grid_dicom(out, grid, source);
  return write_grid_nifti(out, grid);
}

/// Whose volume it is, for a DICOM file.
Result<DicomIdentity> identity_for(const ConvertOptions& options) {
  if (options.patient.empty()) return DicomIdentity{};
  if (options.out.ends_with(".dcm")) return read_identity(options.patient);
  return Error{ErrorCode::kInvalidArgument, "--patient is for DICOM, expected --out x.dcm with it"};
}

/// Scan converts one volume. The file is written whole or not at all.
Result<void> convert_to_grid(const ConvertOptions& options) {
  Doorbell bell;
  ProbeLink probe(bell, bell);
  auto source = open_source(
      options.input, {.geometry_path = options.geometry_path, .pace = SourcePace::kAsFastAsTaken}, probe);
  if (!source) return source.error();
  OfflineVolumes volumes(**source);
  const auto volume = volumes.pick(options.volume);
  if (!volume) return volume.error();
  const auto identity = identity_for(options);
  if (!identity) return identity.error();
  const double spacing_mm = options.spacing_mm.value_or(usual_spacing_mm(**volume));
  Result<GridVolume> grid = Error{};
  {
    ProgressLine line;
    grid = scan_converted(**volume, spacing_mm, line.shares());
  }
  if (!grid) return grid.error();
  const FrameOrigin origin = (*source)->description().origin;
  if (auto written = write_grid(options.out, *grid,
                                {.geometry = (*volume)->geometry(),
                                 .acquired_utc_s = (*source)->description().begun_utc_s,
                                 .identity = *identity,
                                 .is_simulated = origin == FrameOrigin::kSimulated});
      !written)
    return written;
  fmt::print("{}: volume {} on a grid of {} x {} x {} voxels of {:.4g} mm\n", options.out,
             (*volume)->stamp().source_volume_index, grid->size[0], grid->size[1], grid->size[2], spacing_mm);
  for (const std::string& note : (*source)->description().notes) fmt::print("note: {}\n", printable(note));
  return {};
}

Result<void> convert_to_sequence(const ConvertOptions& options) {
  Result<void> written;
  {
    ProgressLine line;
    written = write_sequence_nrrd(
        options.out, {.path = options.input, .geometry_path = options.geometry_path}, line.shares());
  }
  if (!written) return written;
  fmt::print("{}: all frames of {}, with their fields\n", options.out, printable(options.input));
  return {};
}

Result<void> convert(const ConvertOptions& options) {
  const auto ends = [&](std::string_view end) { return options.out.ends_with(end); };
  if (ends(".seq.nrrd")) {
    if (!options.volume && !options.spacing_mm) return convert_to_sequence(options);
    return Error{
        ErrorCode::kInvalidArgument,
        "--volume and --spacing are for a volume on a grid, expected .nrrd, .nii, .nii.gz or .dcm with them"};
  }
  if (ends(".nrrd") || ends(".nii") || ends(".nii.gz") || ends(".dcm")) return convert_to_grid(options);
  if (ends(".mha") || ends(".mhd")) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("a PLUS sequence is what record writes, expected fanlight record {} --fast --out {}",
                    printable(options.input), printable(options.out))};
  }
  if (ends(".ply") || ends(".stl")) {
    return Error{
        ErrorCode::kInvalidArgument,
        fmt::format("a surface is what render finds, expected fanlight render {} --surface {} --out x.png",
                    printable(options.input), printable(options.out))};
  }
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("{} has no ending that is known, expected .seq.nrrd (all frames), .nrrd, .nii, .nii.gz or "
                  ".dcm (one volume on a grid)",
                  printable(options.out))};
}

}  // namespace

Command add_convert_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "convert", "Convert a recording to another format, or one of its volumes to a Cartesian grid");
  const auto options = std::make_shared<ConvertOptions>();
  command->add_option("INPUT", options->input, "A recording, or another source if the output is a grid")
      ->required();
  command
      ->add_option(
          "--out", options->out,
          "Output file: x.seq.nrrd for all frames; x.nrrd, x.nii, x.nii.gz or x.dcm for one volume on a grid")
      ->required()
      ->type_name("FILE");
  command->add_option("--geometry", options->geometry_path, "TOML file with the geometry of the recording")
      ->type_name("FILE");
  command
      ->add_option("--patient", options->patient,
                   "JSON file with the patient and the order for x.dcm, as fanlight worklist saves it")
      ->type_name("FILE");
  command->add_option("--volume", options->volume, "Number of the volume; default: the first complete one")
      ->check(CLI::NonNegativeNumber)
      ->type_name("N");
  command
      ->add_option("--spacing", options->spacing_mm,
                   "Grid spacing, 0.01 to 50 mm; default: about 256 voxels along the longest side")
      ->type_name("MM");
  return [options] { return convert(*options); };
}

}  // namespace fanlight
