// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acquisition/acquisition_thread.hpp"
#include "acquisition/assembly/dropped_sweeps.hpp"
#include "proto/model/picture.hpp"

namespace fanlight {

/// What the report says of one volume.
struct RenderReport {
  std::string input;  ///< as it was given
  const Picture& picture;
  std::vector<DroppedSweep> dropped;  ///< before the volume
  std::vector<std::string> notes;     ///< about the source
  std::string device;
  std::vector<float> depth_5_50_95_mm;  ///< empty without a surface
  bool speckle_filter_left_out = false;
  double total_ms = 0;
};

/// `smooth_mm`: the depth map of the picture.
RenderReport report_of(const std::string& input, const Picture& picture, const std::vector<float>& smooth_mm);

/// What became of the frames of an input.
struct FrameCounts {
  std::uint64_t received = 0;
  std::uint64_t unused = 0;   ///< of them, in no volume
  std::uint64_t missing = 0;  ///< that never came
};
FrameCounts frame_counts(const AcquisitionCounters& counters);

/// What is measured in the pixels of one volume; the same on the same device.
nlohmann::ordered_json figures_json(const RenderReport& report);

nlohmann::ordered_json dropped_json(const std::vector<DroppedSweep>& dropped);
void print_dropped(std::FILE* out, const std::vector<DroppedSweep>& dropped);

void print_json(std::FILE* out, const RenderReport& report);
void print_text(std::FILE* out, const RenderReport& report);

}  // namespace fanlight
