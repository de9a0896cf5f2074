#include "proto/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace fanlight {
namespace {

TEST(Scene, EveryFieldReadsBackWhatWasSet) {
  for (const SceneField& field : scene_fields()) {
    Scene scene;
    for (const double value : {field.minimum, field.maximum}) {
      ASSERT_TRUE(set_field(scene, field, value)) << field.name;
      EXPECT_EQ(field.get(scene), value) << field.name;
    }
  }
}

TEST(Scene, EveryFieldIsItsOwn) {
  std::set<std::string_view> names;
  for (const SceneField& field : scene_fields()) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    Scene scene;
    const double other = field.get(scene) == field.minimum ? field.maximum : field.minimum;
    field.set(scene, other);
    int changed = 0;
    for (const SceneField& each : scene_fields()) changed += each.get(scene) != each.get(Scene{});
    EXPECT_EQ(changed, 1) << field.name << " shares a member with another field";
    EXPECT_EQ(first_pass_changed(Scene{}, scene), field.first_pass) << field.name;
  }
}

TEST(Scene, DefaultsAreAllowed) {
  Scene scene;
  EXPECT_TRUE(check(scene));
  for (const SceneField& field : scene_fields()) {
    EXPECT_TRUE(set_field(scene, field, field.get(scene))) << field.name;
  }
}

TEST(Scene, RefusesWhatIsOutOfRangeAndSaysWhatIsAllowed) {
  for (const SceneField& field : scene_fields()) {
    Scene scene;
    for (const double value : {field.minimum - 1, field.maximum + 1, std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()}) {
      const auto refused = set_field(scene, field, value);
      ASSERT_FALSE(refused) << field.name << " took " << value;
      EXPECT_NE(refused.error().message.find("expected"), std::string::npos);
    }
    EXPECT_EQ(first_pass_changed(Scene{}, scene), FirstPass::kNone) << field.name << " changed all the same";
  }
}

TEST(Scene, RefusesAnEvenFilterAndAnOddWindow) {
  Scene scene;
  EXPECT_FALSE(set_field(scene, *find_scene_field("filter.size"), 4.0));
  EXPECT_TRUE(set_field(scene, *find_scene_field("filter.size"), 5.0));
  EXPECT_FALSE(set_field(scene, *find_scene_field("detector.window"), 7.0));
  EXPECT_FALSE(set_field(scene, *find_scene_field("filter.size"), 5.5));
}

TEST(Scene, ReadsTextAsANumberOrAChoice) {
  Scene scene;
  EXPECT_TRUE(set_field(scene, *find_scene_field("detector.sign"), std::string_view("either")));
  EXPECT_EQ(scene.detector.sign, EdgeSign::kEither);
  const auto refused = set_field(scene, *find_scene_field("detector.sign"), std::string_view("up"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "detector.sign is \"up\", expected one of dark-to-bright, bright-to-dark, either");
  EXPECT_TRUE(set_field(scene, *find_scene_field("detector.threshold"), std::string_view("12.5")));
  EXPECT_EQ(scene.detector.threshold, 12.5);
  for (const std::string_view text : {"", "12x", "nan", "1e999", " 3"}) {
    EXPECT_FALSE(set_field(scene, *find_scene_field("detector.threshold"), text)) << text;
  }
}

TEST(Scene, RefusesFieldsThatContradictEachOther) {
  Scene scene;
  scene.rays.start_mm = 100;
  scene.rays.end_mm = 100;
  EXPECT_FALSE(check(scene));
}

TEST(Scene, FramesTheFanFromTheProbe) {
  const FanGeometry geometry{.columns = 512,
                             .rows = 512,
                             .pixel_width_mm = 0.3125,
                             .pixel_height_mm = 0.3125,
                             .face_column = 255.5,
                             .face_row = 0,
                             .motor_radius_mm = 30,
                             .sector = {}};
  const Scene scene = scene_for(geometry, radians(-35), radians(35));
  EXPECT_TRUE(check(scene));
  EXPECT_NEAR(scene.camera.target.x_mm, 0, 1e-9);
  EXPECT_NEAR(scene.camera.target.y_mm, geometry.depth_mm() / 2, 1e-9);
  EXPECT_NEAR(scene.camera.distance_mm, scene.camera.target.y_mm, 1e-9);
  EXPECT_GE(scene.camera.field_mm, geometry.right_mm() - geometry.left_mm());
}

TEST(Scene, FramesAFanThatIsLargerThanAnyPicture) {
  const FanGeometry geometry{.columns = 4096,
                             .rows = 4096,
                             .pixel_width_mm = 10,
                             .pixel_height_mm = 10,
                             .face_column = 0,
                             .face_row = 0,
                             .motor_radius_mm = 1000,
                             .sector = {}};
  Scene scene = scene_for(geometry, radians(-80), radians(80));
  EXPECT_TRUE(check(scene));
  for (const SceneField& field : scene_fields()) {
    EXPECT_TRUE(set_field(scene, field, field.get(scene))) << field.name;
  }
}

}  // namespace
}  // namespace fanlight
