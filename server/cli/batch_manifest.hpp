// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/base/result.hpp"
#include "server/cli/option_sources.hpp"

namespace fanlight {

/// One sweep of a batch, as its manifest says.
struct BatchSweep {
  std::string name;                     ///< of its outputs; may have folders: "ward-3/liver-001"
  std::string input;                    ///< as the manifest has it
  std::filesystem::path folder;         ///< the manifest's, from which paths lead
  std::string from;                     ///< "sweeps.toml, line 12"
  std::vector<ConfiguredOption> given;  ///< options of `fanlight render`; its own before those for all

  bool is_simulated() const { return input.starts_with("phantom:"); }
  /// As `fanlight render` takes it.
  std::string source() const { return is_simulated() ? input : (folder / input).string(); }
};

struct BatchManifest {
  std::filesystem::path path;
  std::filesystem::path folder;  ///< of the outputs
  std::vector<BatchSweep> sweeps;
};

/// Reads a manifest: TOML, or a table of comma-separated values where the name ends in .csv.
///
///   folder = "rendered"              # of the outputs; from the manifest's own; "." without it
///   [all]                            # options of `fanlight render` for every sweep
///   size = "256x256"
///   depth = "{name}.exr"
///   [[sweep]]
///   input = "archive/liver-001.igs.mha"
///   name = "liver-001"               # without it, the name of the input without its endings
///   detector.threshold = 30
///
/// Of a table, the first row has the names: input, name, and options. An empty cell sets nothing. The outputs
/// then lie in the folder of the table.
///
/// Errors, kInvalidArgument with the place: no manifest, no sweep, a sweep without input, a source that is
/// live, names that are taken twice or lead out of the folder.
Result<BatchManifest> read_manifest(const std::filesystem::path& path);

/// Whether a name of an output, or a folder in it, leads nowhere else than into the folder of the outputs.
bool stays_inside(const std::string& name);

/// A part of a batch: every sweep whose position from 0 on leaves the rest index - 1 when divided by count.
struct Shard {
  std::uint32_t index = 1;  ///< from 1 to count
  std::uint32_t count = 1;

  bool has(std::size_t position) const { return position % count == index - 1; }
};

/// Parses "2/16". kInvalidArgument.
Result<Shard> parse_shard(const std::string& text);

}  // namespace fanlight
