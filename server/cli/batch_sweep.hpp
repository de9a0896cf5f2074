// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "proto/base/result.hpp"
#include "renderer/pipelines/pipeline_store.hpp"
#include "renderer/vulkan/render_device.hpp"
#include "server/cli/batch_manifest.hpp"
#include "server/cli/batch_record.hpp"
#include "server/cli/render_options.hpp"

namespace fanlight {

/// What does not depend on the sweep.
struct BatchRun {
  std::filesystem::path folder;  ///< of the outputs
  std::string gpu;               ///< part of its name; empty: the best one
  std::string host;
  std::string shard;              ///< "2/16"
  RenderDevice device;            ///< opened by the first sweep
  PipelineStore pipelines;        ///< of the device, kept from sweep to sweep
  std::function<bool()> stopped;  ///< asked between two volumes
  bool is_in_trouble = false;     ///< the GPU or the folder of the outputs: the next sweep will have it, too
};

/// The options of a sweep as a command line of `fanlight render` would give them, with {name} in the names of
/// files replaced. Not movable: the parser holds on to it.
class SweepOptions {
 public:
  explicit SweepOptions(const BatchSweep& sweep);
  SweepOptions(const SweepOptions&) = delete;
  SweepOptions& operator=(const SweepOptions&) = delete;

  /// kInvalidArgument, with the place in the manifest: an option that is not known or refused, or options
  /// that exclude one another.
  Result<void> read(const std::filesystem::path& folder);

  const RenderOptions& options() const { return options_; }
  /// The options in force, by name.
  nlohmann::ordered_json json() const;

 private:
  const BatchSweep& sweep_;
  CLI::App command_;
  RenderOptions options_;
  OptionOrigins origins_;
};

enum class SweepEnd : std::uint8_t {
  kRendered,
  kThere,   ///< the same was rendered before
  kFailed,  ///< for the recording's sake: the record says why
};

/// Renders a sweep, unless its outputs are there already and were made of the same input with the same
/// options by the same version; and writes its record, last. Errors, which leave no record: kStopped;
/// kUnavailable, kBroken, kLost: this machine has trouble, and another try may do.
Result<SweepEnd> render_sweep(const BatchSweep& sweep, BatchRun& run, BatchRecord& record);

/// Where the record of a sweep lies.
std::filesystem::path record_path(const std::filesystem::path& folder, const BatchSweep& sweep);

}  // namespace fanlight
