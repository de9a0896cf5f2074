// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "acquisition/replay/recording_file.hpp"
#include "proto/model/fan_geometry.hpp"
#include "tests/support/data_folder.hpp"

namespace fanlight::test {

/// Geometry of the probe BPC8-4/10 with the settings of the recording (shared/data/README.md).
inline FanGeometry oracle_probe(const FrameSequence& lines) {
  return {.kind = FrameKind::kConvexLines,
          .columns = lines.columns,
          .rows = lines.rows,
          .pixel_height_mm = 72.0 / 3640,
          .face_column = 95.0 / 2,
          .face_row = 0,
          .motor_radius_mm = 28,
          .probe_radius_mm = 10,
          .line_pitch_deg = 150.0 / 95};
}

/// Position of a pixel of a scan-converted picture, from the constants of that conversion
/// (shared/data/README.md).
inline PlanePoint oracle_point(const FanGeometry& geometry, std::uint32_t column, std::uint32_t row) {
  constexpr double kPixelMm = 0.15;
  const double from_apex_mm = 10 + (row - 87.0) * kPixelMm;
  return {.x_mm = (column - 409.5) * kPixelMm, .depth_mm = from_apex_mm - geometry.probe_radius_mm};
}

/// Pearson's correlation coefficient of the pairs added.
class Correlation {
 public:
  void add(double a, double b) {
    ++count_;
    sum_a_ += a;
    sum_b_ += b;
    squares_a_ += a * a;
    squares_b_ += b * b;
    products_ += a * b;
  }
  double count() const { return count_; }
  double value() const {
    const double variance_a = squares_a_ - sum_a_ * sum_a_ / count_;
    const double variance_b = squares_b_ - sum_b_ * sum_b_ / count_;
    return (products_ - sum_a_ * sum_b_ / count_) / std::sqrt(variance_a * variance_b);
  }

 private:
  double count_ = 0;
  double sum_a_ = 0;
  double sum_b_ = 0;
  double squares_a_ = 0;
  double squares_b_ = 0;
  double products_ = 0;
};

/// Scan lines of a real curved array, and the pictures that independent software computed from them.
struct Oracle {
  FrameSequence lines;
  FrameSequence pictures;
};

inline constexpr const char* kOracleLines = "UltrasonixCurvilinearBrightnessData.igs.mha";
inline constexpr const char* kOraclePictures = "UltrasonixCurvilinearScanConvertedData.igs.mha";

inline bool has_oracle() {
  return std::filesystem::exists(data_folder() / kOracleLines) &&
         std::filesystem::exists(data_folder() / kOraclePictures);
}

/// Precondition: has_oracle(). Aborts if a file cannot be read.
inline Oracle read_oracle() {
  constexpr std::uint64_t kMaxBytes = 1 << 24;
  auto lines = read_recording_file(data_folder() / kOracleLines, kMaxBytes);
  auto pictures = read_recording_file(data_folder() / kOraclePictures, kMaxBytes);
  return {std::move(lines).value(), std::move(pictures).value()};
}

}  // namespace fanlight::test
