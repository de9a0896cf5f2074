// SPDX-License-Identifier: Apache-2.0
#include "proto/model/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fanlight {
namespace {

/// Texts that the field takes, as it writes them.
std::vector<std::string_view> texts_of(const SceneField& field) {
  if (field.name == "cuts.shapes") return {"balls 6 at 1 2 3", ""};
  return {"7 #123456 0.5", "0 #000000 0, 255 #ffffff 0.999"};
}

/// Sets the field to another allowed value.
void change(Scene& scene, const SceneField& field) {
  if (field.is_text()) {
    ASSERT_TRUE(set_field(scene, field, texts_of(field).front())) << field.name;
  } else {
    field.set(scene, field.get(scene) == field.minimum ? field.maximum : field.minimum);
  }
}

/// Names of the fields in which the scenes differ.
std::set<std::string_view> changed(const Scene& from, const Scene& to) {
  std::set<std::string_view> names;
  for (const SceneField& field : scene_fields()) {
    if (!field.same(from, to)) names.insert(field.name);
  }
  return names;
}

TEST(Scene, EveryNumberReadsBackWhatWasSet) {
  for (const SceneField& field : scene_fields()) {
    if (field.is_text()) continue;
    Scene scene;
    for (const double value : {field.minimum, field.maximum}) {
      ASSERT_TRUE(set_field(scene, field, value)) << field.name;
      EXPECT_EQ(field.get(scene), value) << field.name;
    }
  }
}

TEST(Scene, EveryTextReadsBackWhatWasSet) {
  for (const SceneField& field : scene_fields()) {
    EXPECT_EQ(field.is_text(), field.set_text != nullptr) << field.name;
    EXPECT_EQ(field.is_text(), field.get == nullptr) << field.name;
    EXPECT_EQ(field.is_text(), field.set == nullptr) << field.name;
    if (!field.is_text()) continue;
    Scene scene;
    for (const std::string_view text : texts_of(field)) {
      ASSERT_TRUE(set_field(scene, field, text)) << field.name;
      EXPECT_EQ(field.get_text(scene), text) << field.name;
      EXPECT_EQ(field_text(scene, field), text) << field.name;
    }
  }
}

TEST(Scene, EveryFieldIsWrittenAsItIsRead) {
  for (const SceneField& field : scene_fields()) {
    Scene scene;
    change(scene, field);
    Scene read;
    ASSERT_TRUE(set_field(read, field, field_text(scene, field))) << field.name;
    EXPECT_TRUE(field.same(scene, read)) << field.name;
  }
}

TEST(Scene, EveryFieldIsItsOwn) {
  std::set<std::string_view> names;
  for (const SceneField& field : scene_fields()) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    Scene before;
    before.mode = Mode::kVolume;  // where the mode shows no glass, that field is as any other
    Scene scene = before;
    change(scene, field);
    EXPECT_EQ(changed(before, scene), std::set{field.name}) << "shares a member with another field";
    EXPECT_EQ(first_pass_changed(before, scene), field.first_pass) << field.name;
    Scene copied = before;
    field.copy(copied, scene);
    EXPECT_EQ(changed(scene, copied).size(), 0U) << field.name << " is not copied";
  }
}

TEST(Scene, DefaultsAreAllowed) {
  Scene scene;
  EXPECT_TRUE(check(scene));
  for (const SceneField& field : scene_fields()) {
    EXPECT_TRUE(set_field(scene, field, field_text(scene, field))) << field.name;
  }
  EXPECT_EQ(changed(Scene{}, scene).size(), 0U);
}

TEST(Scene, RefusesWhatIsOutOfRangeAndSaysWhatIsAllowed) {
  for (const SceneField& field : scene_fields()) {
    if (field.is_text()) continue;
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

TEST(Scene, RefusesATextThatIsNoneAndNamesTheField) {
  for (const SceneField& field : scene_fields()) {
    if (!field.is_text()) continue;
    Scene scene;
    for (const std::string_view text : {"", "skin", "0 #591f14", "9 #591f14 0, 8 #591f14 0"}) {
      if (text.empty() && set_field(scene, field, text)) continue;  // nothing is cut away
      const auto refused = set_field(scene, field, text);
      ASSERT_FALSE(refused) << field.name << " took \"" << text << "\"";
      EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
      EXPECT_TRUE(refused.error().message.starts_with(std::string(field.name) + ": "))
          << refused.error().message;
      EXPECT_NE(refused.error().message.find("expected"), std::string::npos) << refused.error().message;
    }
    EXPECT_EQ(changed(Scene{}, scene).size(), 0U) << field.name << " changed all the same";
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

TEST(Scene, RefusesMoreSamplesThanARayMayTake) {
  Scene scene;
  scene.rays.end_mm = 2000;
  scene.rays.step_mm = 0.24;
  EXPECT_FALSE(check(scene));
  scene.rays.step_mm = 0.25;
  EXPECT_TRUE(check(scene));
}

TEST(Scene, RefusesACropBoxThatIsInsideOut) {
  using Crop = Scene::Crop;
  const std::pair<double Crop::*, double Crop::*> axes[] = {
      {&Crop::left_mm, &Crop::right_mm}, {&Crop::near_mm, &Crop::far_mm}, {&Crop::below_mm, &Crop::above_mm}};
  for (const auto& [low, high] : axes) {
    Scene scene;
    scene.crop.*low = 10;
    scene.crop.*high = 11;
    EXPECT_TRUE(check(scene));
    for (const double value : {10.0, 9.0}) {
      scene.crop.*high = value;
      const auto refused = check(scene);
      ASSERT_FALSE(refused);
      EXPECT_TRUE(refused.error().message.starts_with("the crop box is")) << refused.error().message;
      EXPECT_NE(refused.error().message.find("expected"), std::string::npos);
    }
  }
}

TEST(Scene, RunsTheEarliestPassThatAChangeNeeds) {
  EXPECT_LT(FirstPass::kPrepare, FirstPass::kCast);
  EXPECT_LT(FirstPass::kCast, FirstPass::kFilter);
  EXPECT_LT(FirstPass::kFilter, FirstPass::kLight);
  EXPECT_LT(FirstPass::kLight, FirstPass::kNone);
  Scene scene;
  EXPECT_EQ(first_pass_changed(Scene{}, scene), FirstPass::kNone);
  scene.light.right_mm += 1;
  EXPECT_EQ(first_pass_changed(Scene{}, scene), FirstPass::kLight);
  scene.filter.size += 2;
  EXPECT_EQ(first_pass_changed(Scene{}, scene), FirstPass::kFilter);
  scene.transfer = TransferFunction::parse("0 #000000 0").value();
  EXPECT_EQ(first_pass_changed(Scene{}, scene), FirstPass::kCast);
  scene.speckle.filter = SpeckleFilter::kMedian;
  EXPECT_EQ(first_pass_changed(Scene{}, scene), FirstPass::kPrepare);
}

TEST(Scene, IsRelitWithWhatPasses2And3AloneRead) {
  Scene cast;
  cast.mode = Mode::kVolume;  // glass is not shown
  Scene newest = cast;
  std::set<std::string_view> expected;
  for (const SceneField& field : scene_fields()) {
    change(newest, field);
    if (field.first_pass >= FirstPass::kFilter) expected.insert(field.name);
  }
  const Scene scene = relit(cast, newest);
  EXPECT_EQ(changed(cast, scene), expected);
  for (const SceneField& field : scene_fields()) {
    EXPECT_TRUE(field.same(scene, expected.contains(field.name) ? newest : cast)) << field.name;
  }
  EXPECT_GE(first_pass_changed(cast, scene), FirstPass::kFilter);
}

TEST(Scene, CastsRaysToBecomeGlassAndToBecomeOpaque) {
  const Scene opaque;
  Scene clear;
  clear.glass.amount = 1;
  Scene half = clear;
  half.glass.amount = 0.5;
  EXPECT_EQ(first_pass_changed(clear, half), FirstPass::kLight);
  EXPECT_EQ(relit(clear, half).glass.amount, 0.5);
  // Pass 1 keeps the edges behind the surface for glass alone.
  EXPECT_EQ(first_pass_changed(opaque, clear), FirstPass::kCast);
  EXPECT_EQ(first_pass_changed(clear, opaque), FirstPass::kCast);
  EXPECT_EQ(relit(opaque, clear).glass.amount, 0);
  EXPECT_EQ(relit(clear, opaque).glass.amount, 1);
  // Where the mode shows no glass, it does not matter.
  for (Scene* const scene : {&clear, &half}) scene->mode = Mode::kSurfaceAndVolume;
  EXPECT_FALSE(is_glass(clear));
  EXPECT_EQ(relit(clear, half).glass.amount, 0.5);
}

/// A fan 16 cm deep and wide.
constexpr FanGeometry kFan{.columns = 512,
                           .rows = 512,
                           .pixel_width_mm = 0.3125,
                           .pixel_height_mm = 0.3125,
                           .face_column = 255.5,
                           .motor_radius_mm = 30};

TEST(Scene, FramesTheFanFromTheProbe) {
  const Scene scene = scene_for(kFan, radians(-35), radians(35));
  EXPECT_TRUE(check(scene));
  EXPECT_NEAR(scene.camera.target.x_mm, 0, 1e-9);
  EXPECT_NEAR(scene.camera.target.y_mm, kFan.depth_mm() / 2, 1e-9);
  EXPECT_NEAR(scene.camera.distance_mm, scene.camera.target.y_mm, 1e-9);
  EXPECT_GE(scene.camera.field_mm, kFan.right_mm() - kFan.left_mm());
}

TEST(Scene, SpansAsMuchOfTheBodyWithItsWindowsInAPictureOfAnotherHeight) {
  const Scene::Filter usual = scene_for(kFan, -0.6, 0.6).filter;
  EXPECT_EQ(usual.holes, Scene{}.filter.holes);
  const Scene::Filter half = scene_for(kFan, -0.6, 0.6, 256).filter;
  EXPECT_EQ(half.size_mm, usual.size_mm);
  EXPECT_NEAR(half.size, usual.size / 2.0, 1);
  EXPECT_NEAR(half.holes, usual.holes / 2.0, 1);
  EXPECT_EQ(scene_for(kFan, -0.6, 0.6, 16).filter.islands, 1) << "none that a small picture could lose";
  EXPECT_EQ(scene_for(kFan, -0.6, 0.6, 2048).filter.size_mm, usual.size_mm);
  EXPECT_EQ(scene_for(kFan, -0.6, 0.6, 2048).filter.size, find_scene_field("filter.size")->maximum);
}

TEST(Scene, HasTheWindowThatWasSetLast) {
  Scene scene = scene_for(kFan, -0.6, 0.6);
  for (const std::string_view name : {"speckle.size", "detector.window", "filter.size"}) {
    const SceneField& counted = *find_scene_field(name);
    const std::string in_mm = name == "detector.window" ? "detector.window_mm" : std::string(name) + "_mm";
    const SceneField& measured = *find_scene_field(in_mm);
    EXPECT_GT(measured.get(scene), 0) << name;
    ASSERT_TRUE(set_field(scene, counted, counted.minimum));
    EXPECT_EQ(measured.get(scene), 0) << name;
    ASSERT_TRUE(set_field(scene, measured, 4));
    EXPECT_EQ(counted.get(scene), counted.minimum) << name << " waits";
  }
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
    EXPECT_TRUE(set_field(scene, field, field_text(scene, field))) << field.name;
  }
}

}  // namespace
}  // namespace fanlight
