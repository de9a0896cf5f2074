// SPDX-License-Identifier: Apache-2.0
#include "proto/model/look.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace fanlight::test {
namespace {

TEST(LookTest, SetsFieldsOfPasses2And3ToAllowedValues) {
  for (const Look& look : looks()) {
    Scene scene;
    for (const Look::Value& value : look.values) {
      const SceneField* const field = find_scene_field(value.field);
      ASSERT_NE(field, nullptr) << value.field;
      EXPECT_GE(field->first_pass, FirstPass::kLight) << value.field << " casts rays or filters";
      const auto set = set_field(scene, *field, value.value);
      EXPECT_TRUE(set) << look.name << ": " << (set ? "" : set.error().message);
    }
  }
}

TEST(LookTest, SetsTheSameFieldsInAllLooks) {
  for (const Look& look : looks()) {
    EXPECT_TRUE(
        std::ranges::equal(look.values, looks().front().values, {}, &Look::Value::field, &Look::Value::field))
        << look.name;
  }
}

TEST(LookTest, LeavesTheRestOfTheSceneAlone) {
  Scene scene;
  scene.light.right_mm = 12;
  scene.detector.threshold = 33;
  ASSERT_TRUE(apply_look(scene, "clinical"));
  EXPECT_EQ(scene.light.right_mm, 12);
  EXPECT_EQ(scene.detector.threshold, 33);
  EXPECT_EQ(scene.material.scatter_mm, 0);
}

TEST(LookTest, IsSkinByDefault) {
  const FanGeometry geometry{.columns = 64,
                             .rows = 64,
                             .pixel_width_mm = 1,
                             .pixel_height_mm = 1,
                             .face_column = 20,
                             .motor_radius_mm = 20};
  const Scene scene = scene_for(geometry, -0.4, 0.5);
  Scene skin = scene;
  ASSERT_TRUE(apply_look(skin, "skin"));
  EXPECT_EQ(first_pass_changed(scene, skin), FirstPass::kNone);
}

TEST(LookTest, RefusesAnUnknownNameAndNamesTheKnownOnes) {
  Scene scene;
  const auto applied = apply_look(scene, "gold");
  ASSERT_FALSE(applied);
  EXPECT_EQ(applied.error().message, "the look is \"gold\", expected one of skin, clinical, paper");
  EXPECT_EQ(first_pass_changed(scene, Scene{}), FirstPass::kNone);
}

}  // namespace
}  // namespace fanlight::test
