// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "acquisition/replay/recording.hpp"
#include "tests/support/igs_file.hpp"
#include "tests/support/kretz_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace {

class KretzTest : public testing::Test {
 protected:
  Result<Recording> open(const std::string& bytes) {
    write_file(folder_ / "x.vol", bytes);
    return Recording::open({.path = folder_ / "x.vol", .geometry_path = {}});
  }
  TemporaryFolder folder_;
};

/// The published formula of SlicerHeart, in mm: x lateral, y elevation, z depth.
Point in_kretz_space(double theta_rad, double phi_rad, double r_mm, double d_mm) {
  const double from_axis_mm = r_mm * std::cos(theta_rad) - d_mm;
  return {r_mm * std::sin(theta_rad), -from_axis_mm * std::sin(phi_rad),
          d_mm * (1 - std::cos(phi_rad)) + r_mm * std::cos(theta_rad) * std::cos(phi_rad)};
}

TEST_F(KretzTest, LiesWhereThePublishedFormulaPutsIt) {
  const auto recording = open(KretzFile::small().bytes());
  ASSERT_TRUE(recording) << recording.error().message;
  const FanGeometry& geometry = recording->summary().geometry;
  EXPECT_EQ(geometry.kind, FrameKind::kConvexLines);
  EXPECT_EQ(geometry.columns, 8U);
  EXPECT_EQ(geometry.rows, 12U);
  EXPECT_NEAR(geometry.probe_radius_mm, 40, 1e-9);
  EXPECT_NEAR(geometry.motor_radius_mm, 23, 1e-9);
  ASSERT_EQ(recording->frames().size(), 6U);
  const double d_mm = 17;
  for (std::uint32_t frame = 0; frame < 6; ++frame) {
    for (std::uint32_t line = 0; line < 8; ++line) {
      for (std::uint32_t sample = 0; sample < 12; ++sample) {
        EXPECT_EQ(recording->frame_pixels(frame)[sample * 8 + line], sample + 12 * line + frame);
        const PlanePoint at = geometry.plane_point({static_cast<double>(line), static_cast<double>(sample)});
        const Point ours = geometry.point(at.x_mm, {recording->frames()[frame].angle_rad, at.depth_mm});
        const Point theirs =
            in_kretz_space(-0.35 + 0.1 * line, -0.45 + 0.18 * frame, 40 + 0.5 * sample, d_mm);
        // Their depth is from the apex of the lines, ours from the probe face. The third axis of a
        // right-handed frame is x cross depth: against their elevation.
        EXPECT_NEAR(ours.x_mm, theirs.x_mm, 1e-9);
        EXPECT_NEAR(ours.y_mm, theirs.z_mm - 40, 1e-9);
        EXPECT_NEAR(ours.z_mm, -theirs.y_mm, 1e-9);
      }
    }
  }
}

TEST_F(KretzTest, IsRefusedInOneSentence) {
  using enum ErrorCode;
  struct Change {
    std::function<void(KretzFile&)> make;
    ErrorCode code;
    const char* sentence;
  };
  const std::vector<Change> changes = {
      {[](KretzFile& file) { file.magic = "KRETZFILE 2.0   "; }, kUnsupported, "another version"},
      {[](KretzFile& file) { file.remove(0xD000, 1); }, kUnsupported, "they are compressed"},
      {[](KretzFile& file) {
         file.remove(0xD000, 1);
         file.items.push_back({0xD600, 1, "frames"});
       },
       kUnsupported, "several volumes (4D)"},
      {[](KretzFile& file) { file.item(0xD000, 1).data.resize(100); }, kUnsupported,
       "100 bytes of voxels stand for 12 x 8 x 6: they are compressed"},
      {[](KretzFile& file) { file.remove(0xC300, 1); }, kUnsupported, "its volume is a Cartesian one"},
      {[](KretzFile& file) { file.remove(0xC100, 1); }, kBadInput, "item C100/0001 is missing"},
      {[](KretzFile& file) { file.item(0xC000, 2).data = "x"; }, kBadInput, "item C000/0002 has 1 bytes"},
      {[](KretzFile& file) { file.item(0xC300, 2).data = KretzFile::table(7, 1.2, 1.9); }, kBadInput,
       "7 angles of lines and 6 of frames, expected 8 and 6"},
      {[](KretzFile& file) { file.item(0xC300, 2).data.replace(16, 8, KretzFile::bytes_of(1.9)); },
       kUnsupported, "line 2 is off an even spread"},
      {[](KretzFile& file) { file.item(0xC300, 1).data.replace(8, 8, KretzFile::bytes_of(std::nan(""))); },
       kBadInput, "the angle of frame 1 is no number"},
      {[](KretzFile& file) { file.item(0xC200, 2).data = KretzFile::bytes_of(-90.0); }, kBadInput,
       "motor_radius_mm is -5"},
  };
  for (const Change& change : changes) {
    KretzFile file = KretzFile::small();
    change.make(file);
    const auto refused = open(file.bytes());
    ASSERT_FALSE(refused) << change.sentence;
    EXPECT_EQ(refused.error().code, change.code) << refused.error().message;
    EXPECT_NE(refused.error().message.find(change.sentence), std::string::npos) << refused.error().message;
  }
}

TEST_F(KretzTest, TellsNothingOfThePatient) {
  const auto recording = open(KretzFile::small().bytes());
  ASSERT_TRUE(recording);
  for (const std::string& note : recording->summary().notes) EXPECT_EQ(note.find("DOE"), std::string::npos);
  for (const auto& value : recording->summary().geometry_values)
    EXPECT_EQ(value.value.find("DOE"), std::string::npos);
}

}  // namespace
}  // namespace fanlight::test
