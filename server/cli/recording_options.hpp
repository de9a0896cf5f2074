// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>

#include "acquisition/record/recorder.hpp"
#include "proto/base/result.hpp"
#include "server/state/recording_proxy.hpp"

namespace fanlight {

/// Options of a server that records.
struct RecordingOptions {
  std::filesystem::path folder;  ///< empty: nothing is recorded
  PixelForm form = PixelForm::kRaw;
  double most_minutes = 0;
  double last_minutes = 0;
  std::optional<double> reserve_mb;  ///< absent: 1 GB, or 5 % of the disk where that is less
  double quota_mb = 0;
  bool at_start = false;

  /// This object must live as long as the command.
  void add_to(CLI::App& command);

  RecordingProxy::Config config() const;
  /// After make_folder().
  Recorder::Config recorder() const;

  /// Creates the folder where it is missing. kInvalidArgument: it cannot be written.
  Result<void> make_folder() const;
};

}  // namespace fanlight
