// SPDX-License-Identifier: Apache-2.0
#include "proto/model/preset.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>
#include <vector>

namespace fanlight::test {
namespace {

TEST(PresetTest, SetsAllowedValuesOfKnownFields) {
  for (const Preset& preset : presets()) {
    ASSERT_NE(std::ranges::find(looks(), preset.look, &Look::name), looks().end()) << preset.look;
    for (const Look::Value& value : preset.values) {
      const SceneField* const field = find_scene_field(value.field);
      ASSERT_NE(field, nullptr) << value.field;
      Scene scene;
      const auto set = set_field(scene, *field, value.value);
      EXPECT_TRUE(set) << preset.name << ": " << (set ? "" : set.error().message);
    }
  }
}

TEST(PresetTest, SetsTheSameFieldsInAllPresets) {
  const auto sorted = [](const Preset& preset) {
    std::vector<std::string_view> names = preset_fields(preset);
    std::ranges::sort(names);
    return names;
  };
  for (const Preset& preset : presets()) EXPECT_EQ(sorted(preset), sorted(presets().front())) << preset.name;
}

TEST(PresetTest, LeavesNothingOfAnotherPreset) {
  for (const Preset& before : presets()) {
    for (const Preset& preset : presets()) {
      Scene scene;
      scene.detector.threshold = 31;
      scene.detector.least_tissue = scene.detector.least_contrast = 1;
      apply_preset(scene, before);
      apply_preset(scene, preset);
      Scene alone;
      apply_preset(alone, preset);
      EXPECT_EQ(first_pass_changed(scene, alone), FirstPass::kNone)
          << preset.name << " after " << before.name;
    }
  }
}

TEST(PresetTest, ShowsTheSurfaceThatWasFoundUnlessItLooksForItsOwn) {
  Scene found;
  found.detector.sign = EdgeSign::kEither;
  found.detector.threshold = 26;
  found.near.before_bone = NearTissueShow::kRemoved;
  for (const Preset& preset : presets()) {
    const bool is_own = preset.name == "bone" || preset.name == "fluid";
    EXPECT_EQ(found_fields(preset).empty(), is_own) << preset.name;
    Scene scene;
    apply_preset(scene, preset, found);
    EXPECT_EQ(scene.detector.threshold, is_own ? 0 : 26) << preset.name;
    EXPECT_EQ(scene.detector.sign, is_own ? EdgeSign::kBrightToDark : EdgeSign::kEither) << preset.name;
    const bool shows_near = preset.name == "fluid";
    EXPECT_EQ(scene.near.before_bone, shows_near ? NearTissueShow::kShown : NearTissueShow::kRemoved);
  }
}

TEST(PresetTest, LeavesViewAndLightWhereTheyAre) {
  for (const Preset& preset : presets()) {
    Scene scene;
    scene.camera.yaw_deg = 30;
    scene.light.right_mm = 12;
    scene.crop.near_mm = 5;
    apply_preset(scene, preset);
    EXPECT_EQ(scene.camera.yaw_deg, 30);
    EXPECT_EQ(scene.light.right_mm, 12);
    EXPECT_EQ(scene.crop.near_mm, 5);
  }
}

}  // namespace
}  // namespace fanlight::test
