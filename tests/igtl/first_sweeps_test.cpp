// SPDX-License-Identifier: Apache-2.0
// What the source finds out by its first images.
#include "acquisition/igtl/first_sweeps.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "acquisition/sequence/plus_fields.hpp"
#include "tests/igtl/sent_messages.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight::test {
namespace first_sweeps_tests {

constexpr std::uint32_t kFrames = 20;  // a sweep

/// Images as they come, without a connection.
class Rig {
 public:
  explicit Rig(const std::string& options = "", std::filesystem::path geometry = {})
      : sweeps(*IgtlAddress::parse("host" + options), std::move(geometry), poses) {}

  /// Adds an image of a sector: bright between two edges from an apex above it.
  void add(const SentImage& sent) {
    SentImage image = sent;
    image.columns = 96;
    image.rows = 80;
    IgtlImage came{.body = body_of(image), .time_ns = static_cast<std::int64_t>(image.time_ms) * 1'000'000};
    pixels_.assign(came.body.part_bytes(), 0);
    for (int row = 8; row < 76; ++row) {
      const double half = 12 + 0.45 * (row - 8);
      for (int column = 0; column < 96; ++column)
        if (std::abs(column - 47.5) <= half) pixels_[row * 96 + column] = 180;
    }
    came.pixels = pixels_;
    index_.clear();
    texts_.clear();
    for (const auto& [name, value] : image.metadata) {
      for (const std::size_t number : {name.size() >> 8, name.size() & 255, std::size_t{0}, std::size_t{3}})
        index_.push_back(static_cast<std::uint8_t>(number));
      for (int shift = 24; shift >= 0; shift -= 8)
        index_.push_back(static_cast<std::uint8_t>(value.size() >> shift));
      texts_.insert(texts_.end(), name.begin(), name.end());
      texts_.insert(texts_.end(), value.begin(), value.end());
    }
    came.metadata = *igtl::Metadata::parse(index_, texts_);
    came.notes = frame_notes(came.metadata);
    sweeps.add(came);
  }

  PoseHistory poses;
  FirstSweeps sweeps;

 private:
  Bytes pixels_;
  Bytes index_;
  Bytes texts_;
};

SentFan fan() {
  return {.columns = 96};
}

/// A pose somewhere in the room.
igtl::GridPose in_room(const igtl::GridPose& pose) {
  const igtl::GridPose room{
      .i_mm = {0, 1, 0}, .j_mm = {-1, 0, 0}, .k_mm = {0, 0, 1}, .first_mm = {100, -50, 30}};
  return igtl::composed(room, pose);
}

bool has_note(const LearnedFan& fan, std::string_view part) {
  return std::ranges::any_of(
      fan.source.notes, [part](const std::string& note) { return note.find(part) != std::string::npos; });
}

TEST(FirstSweeps, FitTheAxisToTheImagesOwnMatrices) {
  Rig rig;
  std::optional<LearnedFan> learned;
  std::uint32_t images = 0;
  for (; images < 200 && !learned; ++images) {
    rig.add({.pose = in_room(fan().pose(angle_deg(images, kFrames)))});
    auto result = rig.sweeps.result(false);
    ASSERT_TRUE(result) << result.error().message;
    learned = *std::move(result);
  }
  ASSERT_TRUE(learned);
  EXPECT_LE(images, 3 * kFrames + 16) << "two turning points are enough";
  EXPECT_EQ(learned->angles, LearnedFan::Angles::kMatrices);
  EXPECT_FALSE(learned->source.counts_volumes);
  EXPECT_EQ(learned->source.usual_frames, kFrames);
  EXPECT_GE(learned->source.frames_per_volume, kFrames + 5);
  EXPECT_NEAR(degrees(learned->source.first_angle_rad), -20, 0.01);
  EXPECT_NEAR(degrees(learned->source.last_angle_rad), 20, 0.01);
  const FanGeometry& geometry = learned->source.geometry;
  EXPECT_NEAR(geometry.pixel_height_mm, 0.5, 1e-6);
  // Row 0 is 30 mm from the axis; the face is seen at row 8.
  EXPECT_NEAR(geometry.face_row, 8, 1.5);
  EXPECT_NEAR(geometry.motor_radius_mm, 30 + geometry.face_row * 0.5, 0.01);
  // The edges meet 12 / 0.45 rows above row 8.
  EXPECT_NEAR(geometry.probe_radius_mm, 12 / 0.45 * 0.5, 2);
  EXPECT_TRUE(has_note(*learned, "which it misses by 0.00 mm"));
  EXPECT_TRUE(has_note(*learned, "guessed by the edges"));
}

TEST(FirstSweeps, FitTheAxisToTransforms) {
  Rig rig;
  std::optional<LearnedFan> learned;
  for (std::uint32_t i = 0; i < 200 && !learned; ++i) {
    const std::uint64_t time_ms = 1'700'000'000'000 + 40 * i;
    // The image lies in the probe's frame of reference; the transform turns that. Another tool rests.
    const igtl::GridPose turned = [&] {
      const double angle = radians(angle_deg(i, kFrames));
      return igtl::GridPose{.j_mm = {0, std::cos(angle), std::sin(angle)},
                            .k_mm = {0, -std::sin(angle), std::cos(angle)}};
    }();
    igtl::GridPose image = fan().pose(0);
    image.first_mm[1] += 30;  // the axis is the origin
    rig.poses.add("StylusToTracker", static_cast<std::int64_t>(time_ms) * 1'000'000, {});
    rig.poses.add("ProbeToTracker", static_cast<std::int64_t>(time_ms) * 1'000'000, in_room(turned));
    rig.add({.pose = image, .time_ms = time_ms});
    auto result = rig.sweeps.result(false);
    ASSERT_TRUE(result) << result.error().message;
    learned = *std::move(result);
  }
  ASSERT_TRUE(learned);
  EXPECT_EQ(learned->angles, LearnedFan::Angles::kTransforms);
  EXPECT_EQ(learned->device.view(), "ProbeToTracker");
  EXPECT_NEAR(learned->source.geometry.motor_radius_mm, 30 + learned->source.geometry.face_row * 0.5, 0.01);
}

TEST(FirstSweeps, TakeTheImagesOwnMatricesWhileAToolIsAtRest) {
  Rig rig;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const std::uint64_t time_ms = 1'700'000'000'000 + 40 * i;
    rig.poses.add("StylusToTracker", static_cast<std::int64_t>(time_ms) * 1'000'000, in_room({}));
    rig.add({.pose = in_room(fan().pose(angle_deg(i, kFrames))), .time_ms = time_ms});
  }
  const auto learned = rig.sweeps.result(false);
  ASSERT_TRUE(learned && *learned);
  EXPECT_EQ((*learned)->angles, LearnedFan::Angles::kMatrices);
  Rig chosen(",transform=StylusToTracker");
  for (std::uint32_t i = 0; i < 64; ++i) {
    const std::uint64_t time_ms = 1'700'000'000'000 + 40 * i;
    chosen.poses.add("StylusToTracker", static_cast<std::int64_t>(time_ms) * 1'000'000, in_room({}));
    chosen.add({.pose = in_room(fan().pose(angle_deg(i, kFrames))), .time_ms = time_ms});
  }
  EXPECT_FALSE(chosen.sweeps.result(true)) << "a tool at rest tells no angle";
}

TEST(FirstSweeps, TakeNoRadiusFromAnotherMotion) {
  Rig rig;
  for (std::uint32_t i = 0; i < 64; ++i)  // a hand tilts the probe while its motor sweeps
    rig.add({.pose = in_room(fan().pose(angle_deg(i, 31))),
             .metadata = {{"MotorAngleDeg", fmt::format("{}", angle_deg(i, kFrames))}}});
  const auto learned = rig.sweeps.result(false);
  ASSERT_FALSE(learned);
  EXPECT_NE(learned.error().message.find("lacks motor_radius_mm"), std::string::npos)
      << learned.error().message;
}

TEST(FirstSweeps, TakeAnglesByNameAndTheRadiusFromPlaces) {
  Rig rig;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const double angle = angle_deg(i, kFrames);
    rig.add({.pose = in_room(fan().pose(angle)),
             .metadata = {{"MotorAngleDeg", fmt::format("{}", angle)},
                          {"VolumeIndex", fmt::format("{}", i / kFrames)},
                          {"FrameIndex", fmt::format("{}", i % kFrames)}}});
  }
  auto learned = rig.sweeps.result(false);
  ASSERT_TRUE(learned) << learned.error().message;
  ASSERT_TRUE(*learned);
  EXPECT_EQ((*learned)->angles, LearnedFan::Angles::kNamed);
  EXPECT_TRUE((*learned)->source.counts_volumes);
  EXPECT_EQ((*learned)->source.usual_frames, kFrames);
  EXPECT_NEAR((*learned)->source.geometry.motor_radius_mm, 30 + (*learned)->source.geometry.face_row * 0.5,
              0.01);
}

TEST(FirstSweeps, RefuseWhatIsNoFanAndSayHowFarItIsFromOne) {
  Rig rig;
  for (std::uint32_t i = 0; i < 64; ++i) {
    igtl::GridPose pose = fan().pose(angle_deg(i, kFrames));
    pose.first_mm[2] += 40 * std::sin(0.1 * i);  // a hand
    rig.add({.pose = pose});
  }
  EXPECT_TRUE(rig.sweeps.result(false)) << "it may be held still later";
  const auto learned = rig.sweeps.result(true);
  ASSERT_FALSE(learned);
  EXPECT_EQ(learned.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(learned.error().message.find("the best axis misses the frames by"), std::string::npos)
      << learned.error().message;
}

TEST(FirstSweeps, SayThatNothingTellsTheAngles) {
  Rig rig;
  for (int i = 0; i < 32; ++i) rig.add({.pose = fan().pose(0)});
  const auto learned = rig.sweeps.result(true);
  ASSERT_FALSE(learned);
  EXPECT_NE(learned.error().message.find("the images have no angles"), std::string::npos)
      << learned.error().message;
}

TEST(FirstSweeps, NameWhatTheGeometryLacks) {
  Rig rig;
  for (std::uint32_t i = 0; i < 64; ++i)
    rig.add(
        {.pose = fan().pose(0), .metadata = {{"MotorAngleDeg", fmt::format("{}", angle_deg(i, kFrames))}}});
  const auto learned = rig.sweeps.result(false);
  ASSERT_FALSE(learned);
  EXPECT_NE(learned.error().message.find("lacks motor_radius_mm"), std::string::npos)
      << learned.error().message;
}

TEST(FirstSweeps, TakeAGeometryFileFirst) {
  const TemporaryFolder folder;
  std::ofstream(folder / "fan.toml") << "motor_radius_mm = 44\nface_column = 40\nface_row = 5\n";
  Rig rig("", folder / "fan.toml");
  for (std::uint32_t i = 0; i < 64; ++i) rig.add({.pose = in_room(fan().pose(angle_deg(i, kFrames)))});
  auto learned = rig.sweeps.result(false);
  ASSERT_TRUE(learned && *learned);
  EXPECT_EQ((*learned)->source.geometry.motor_radius_mm, 44);
  EXPECT_EQ((*learned)->source.geometry.face_row, 5);
}

TEST(FirstSweeps, BelieveAFanlightAtItsFirstImage) {
  const RecordingFacts facts{.source = "phantom:",
                             .geometry = {.columns = 96,
                                          .rows = 80,
                                          .pixel_width_mm = 0.5,
                                          .pixel_height_mm = 0.5,
                                          .face_column = 47.5,
                                          .face_row = 3,
                                          .motor_radius_mm = 40,
                                          .probe_radius_mm = 50,
                                          .sector = {.half_angle_deg = 33, .reach_mm = 90}},
                             .frames_per_volume = 35,
                             .usual_frames = 30,
                             .simulated = true,
                             .first_angle_rad = -0.5,
                             .last_angle_rad = 0.5,
                             .begun_utc_s = 1'700'000'000};
  SentImage sent;
  sent.metadata = fanlight_fields(facts);
  for (const auto& field :
       frame_fields(facts, {.stamp = {.sequence = 7, .volume_index = 2, .frame_index = 1, .angle_rad = 0.1}}))
    sent.metadata.push_back(field);
  Rig rig;
  rig.add(sent);
  auto learned = rig.sweeps.result(false);
  ASSERT_TRUE(learned) << learned.error().message;
  ASSERT_TRUE(*learned);
  EXPECT_TRUE((*learned)->sequence_named);
  EXPECT_EQ((*learned)->source.geometry, facts.geometry);
  EXPECT_EQ((*learned)->source.frames_per_volume, 35U);
  EXPECT_EQ((*learned)->source.first_angle_rad, -0.5);
  EXPECT_TRUE((*learned)->source.simulated);
}

TEST(FirstSweeps, RefuseASweepThatNoMemoryHolds) {
  RecordingFacts facts{.source = "x",
                       .geometry = {.columns = 96,
                                    .rows = 80,
                                    .pixel_width_mm = 0.5,
                                    .pixel_height_mm = 0.5,
                                    .motor_radius_mm = 40},
                       .frames_per_volume = 4'000'000'000};
  SentImage sent;
  sent.metadata = fanlight_fields(facts);
  for (const auto& field : frame_fields(facts, {.stamp = {.angle_rad = 0.1}})) sent.metadata.push_back(field);
  Rig rig;
  rig.add(sent);
  const auto learned = rig.sweeps.result(false);
  ASSERT_FALSE(learned);
  EXPECT_EQ(learned.error().code, ErrorCode::kUnsupported);
}

TEST(WhyNoFrame, NamesVolumesColoursAndNumbers) {
  SentImage sent;
  igtl::ImageBody body = body_of(sent);
  EXPECT_EQ(why_no_frame(body), "");
  body.size[2] = 5;
  EXPECT_NE(why_no_frame(body).find("5 slices"), std::string::npos);
  body.size[2] = 1;
  body.components = 3;
  EXPECT_NE(why_no_frame(body).find("3 numbers"), std::string::npos);
  body.components = 1;
  body.scalar = igtl::ScalarType::kFloat32;
  EXPECT_NE(why_no_frame(body).find("type 10"), std::string::npos);
  body.scalar = igtl::ScalarType::kInt16;
  body.size[0] = 5000;
  EXPECT_NE(why_no_frame(body).find("5000 x 12"), std::string::npos);
}

}  // namespace first_sweeps_tests
}  // namespace fanlight::test
