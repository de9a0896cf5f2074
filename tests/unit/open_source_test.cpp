// SPDX-License-Identifier: Apache-2.0
#include "acquisition/open_source.hpp"

#include <gtest/gtest.h>

#include "tests/support/igs_file.hpp"
#include "tests/support/temporary_folder.hpp"

namespace fanlight {
namespace {

Result<std::unique_ptr<FrameSource>> opened(std::string_view text, const SourceOptions& options) {
  static Doorbell bell;
  static ProbeLink link(bell, bell);
  return open_source(text, options, link);
}

TEST(OpenSource, OpensThePhantomWithItsOptions) {
  const auto source = opened("phantom:columns=32,rows=16,frames=9", {});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->description().name, "phantom:");
  EXPECT_EQ((*source)->description().geometry.columns, 32U);
  EXPECT_EQ((*source)->description().frames_per_volume, 9U);
}

TEST(OpenSource, ShowsTheFaceByTheUsualProbeWhereNothingIsSaid) {
  const auto source = opened("phantom:", {});
  ASSERT_TRUE(source) << source.error().message;
  const SourceDescription& usual = (*source)->description();
  EXPECT_EQ(usual.geometry.kind, FrameKind::kConvexLines);
  EXPECT_EQ(usual.geometry.columns, 192U);
  EXPECT_EQ(usual.frames_per_volume, 60U);
  EXPECT_EQ(usual.geometry.motor_radius_mm, 23);
  EXPECT_TRUE(usual.subject) << "only the face has a subject to look at";
}

TEST(OpenSource, ASimulatedProbeThatEndsLosesNoFrameWhereThatIsAskedFor) {
  EXPECT_TRUE((*opened("phantom:volumes=1", {.ends_whole = true}))->waits());
  EXPECT_FALSE((*opened("phantom:volumes=1", {}))->waits()) << "as a probe";
  EXPECT_FALSE((*opened("phantom:", {.ends_whole = true}))->waits());
}

TEST(OpenSource, OpensARecordingWithAndWithoutItsScheme) {
  const test::TemporaryFolder folder;
  const auto path = folder / "sweep.igs.mha";
  test::write_file(path, test::fan_recording(4, 1, 20).bytes());
  for (const std::string& text : {path.string(), "replay:" + path.string()}) {
    const auto source = opened(text, {.geometry_path = {}, .pace = SourcePace::kAsFastAsTaken});
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_EQ((*source)->description().name, "replay:" + path.string());
  }
}

TEST(OpenSource, PassesItsOptionsOn) {
  const test::TemporaryFolder folder;
  const auto path = folder / "sweep.igs.mha";
  test::write_file(path, test::fan_recording(4, 1, 20).bytes());
  test::write_file(folder / "geometry.toml", "motor_radius_mm = 44\n");
  const auto source = opened(path.string(), {.geometry_path = folder / "geometry.toml",
                                             .pace = SourcePace::kAsFastAsTaken,
                                             .ending = ReplaySource::Ending::kToAndFro});
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->description().geometry.motor_radius_mm, 44);
  for (int i = 0; i < 9; ++i) EXPECT_TRUE((*source)->next_frame({}).value()) << "it never ends";
}

TEST(OpenSource, RefusesInOneSentence) {
  EXPECT_EQ(opened("", {}).error().message,
            "the source is empty, expected phantom:, replay:PATH, usb:VENDOR:PRODUCT or igtl:HOST");
  EXPECT_EQ(opened("replay:", {}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(opened("/no/such/file.mha", {}).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(opened("phantom:colour=red", {}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(opened("/no/such/file.mha", {.geometry_path = {}, .speed = 0}).error().code,
            ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace fanlight
