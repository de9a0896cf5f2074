// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "proto/base/result.hpp"

namespace fanlight {

/// A file, by its content.
struct FileDigest {
  std::string file;
  std::uint64_t bytes = 0;
  std::string sha256;  ///< hexadecimal

  bool operator==(const FileDigest&) const = default;
};

/// The SHA-256 of a file (FIPS 180-4), read in pieces. `name`: what the digest calls it. kNotFound: it cannot
/// be read.
Result<FileDigest> digest_of(const std::filesystem::path& path, const std::string& name);

/// What `fanlight batch` writes next to the outputs of a sweep: NAME.json. A sweep is done where this says
/// so, it was asked for the same, and the outputs are there.
struct BatchRecord {
  // What was asked for. Equal requests on one device give equal outputs.
  std::string version;             ///< of Fanlight
  std::string input;               ///< as the manifest has it
  nlohmann::ordered_json options;  ///< of `fanlight render`, by name
  std::vector<FileDigest> inputs;  ///< of a simulated sweep none

  // What came of it.
  std::string trouble;              ///< why there are no outputs; empty: there are
  std::vector<FileDigest> outputs;  ///< from the folder of the outputs
  nlohmann::ordered_json volumes = nlohmann::ordered_json::array();  ///< figures_json() of each
  std::uint64_t interpolated = 0;                                    ///< volumes with interpolated frames
  std::uint64_t frames_received = 0;
  std::uint64_t frames_unused = 0;
  std::uint64_t frames_missing = 0;
  nlohmann::ordered_json dropped = nlohmann::ordered_json::array();  ///< dropped_json()
  std::vector<std::string> notes;

  // Of this run; the only part that differs between two runs on one kind of device.
  std::string device;
  std::string host;
  std::string shard;
  std::string begun;  ///< UTC, ISO 8601
  double seconds = 0;

  bool asks_the_same(const BatchRecord& other) const {
    return version == other.version && input == other.input && options == other.options &&
           inputs == other.inputs;
  }
};

nlohmann::ordered_json json_of(const BatchRecord& record);

/// The record in a file. nullopt: there is none, or what is there is no record (it is overwritten then).
std::optional<BatchRecord> read_record(const std::filesystem::path& path);

/// Whether all outputs of a record are in the folder, in the sizes that they had.
bool has_outputs(const BatchRecord& record, const std::filesystem::path& folder);

}  // namespace fanlight
