// Scan lines of a real curved array against the pictures that someone else's code made of them: if our reader
// turned the lines, or our geometry bent them, in any other way, the two would not agree.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <optional>

#include "acquisition/igs_sequence.hpp"
#include "proto/fan_geometry.hpp"
#include "tests/support/data_folder.hpp"

namespace fanlight {
namespace {

constexpr std::uint64_t kMaxBytes = 1 << 24;

/// The probe BPC8-4/10 as it was set (shared/data/README.md).
FanGeometry probe(const IgsSequence& lines) {
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

/// Where a pixel of the twin lies, by its maker's numbers.
PlanePoint twin_point(const FanGeometry& geometry, std::uint32_t column, std::uint32_t row) {
  constexpr double kPixelMm = 0.15;
  const double from_apex_mm = 10 + (row - 87.0) * kPixelMm;
  return {.x_mm = (column - 409.5) * kPixelMm, .depth_mm = from_apex_mm - geometry.probe_radius_mm};
}

/// The frame at a place between its pixels, bilinear; nullopt beside it.
std::optional<double> grey_at(std::span<const std::uint8_t> frame, const FanGeometry& geometry,
                              FramePlace at) {
  const double left = std::floor(at.column);
  const double above = std::floor(at.row);
  if (!(left >= 0 && above >= 0 && left < geometry.columns - 1 && above < geometry.rows - 1)) return {};
  const std::size_t first =
      static_cast<std::size_t>(above) * geometry.columns + static_cast<std::size_t>(left);
  const auto across = [&](std::size_t pixel) {
    return std::lerp(double{1} * frame[pixel], double{1} * frame[pixel + 1], at.column - left);
  };
  return std::lerp(across(first), across(first + geometry.columns), at.row - above);
}

/// Pearson's coefficient over the pairs added.
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

/// The twin against our conversion, inside the fan. `mirror`: -1 swaps left and right of ours.
Correlation correlation(const IgsSequence& lines, const IgsSequence& twin, std::size_t frame, double mirror) {
  const FanGeometry geometry = probe(lines);
  Correlation found;
  for (std::uint32_t row = 0; row < twin.rows; ++row) {
    for (std::uint32_t column = 0; column < twin.columns; ++column) {
      PlanePoint at = twin_point(geometry, column, row);
      at.x_mm *= mirror;
      const auto ours = grey_at(lines.frame_pixels(frame), geometry, geometry.frame_place(at));
      if (ours) found.add(*ours, twin.frame_pixels(frame)[row * twin.columns + column]);
    }
  }
  return found;
}

TEST(ScanConversionOracle, OurConversionOfEachFrameIsItsTwin) {
  const auto lines_path = test::data_folder() / "UltrasonixCurvilinearBrightnessData.igs.mha";
  const auto twin_path = test::data_folder() / "UltrasonixCurvilinearScanConvertedData.igs.mha";
  for (const auto& path : {lines_path, twin_path}) {
    if (!std::filesystem::exists(path))
      GTEST_SKIP() << path << " is not there; set FANLIGHT_DATA to its folder";
  }
  const auto lines = read_igs_sequence(lines_path, kMaxBytes);
  ASSERT_TRUE(lines) << lines.error().message;
  const auto twin = read_igs_sequence(twin_path, kMaxBytes);
  ASSERT_TRUE(twin) << twin.error().message;
  ASSERT_EQ(lines->columns, 96U);
  ASSERT_EQ(lines->rows, 3640U);
  ASSERT_EQ(lines->frames.size(), twin->frames.size());
  ASSERT_TRUE(check(probe(*lines)));

  for (std::size_t frame = 0; frame < lines->frames.size(); ++frame) {
    const Correlation ours = correlation(*lines, *twin, frame, 1);
    const Correlation mirrored = correlation(*lines, *twin, frame, -1);
    fmt::print("frame {}: correlation {:.5f} over {} pixels, mirrored {:.3f}\n", frame, ours.value(),
               ours.count(), mirrored.value());
    EXPECT_GT(ours.count(), 0.5 * twin->columns * twin->rows);
    EXPECT_GE(ours.value(), 0.999) << "frame " << frame;
    EXPECT_LT(mirrored.value(), 0.5) << "frame " << frame;
  }
}

}  // namespace
}  // namespace fanlight
