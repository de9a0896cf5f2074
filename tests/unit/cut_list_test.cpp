// SPDX-License-Identifier: Apache-2.0
#include "proto/model/cut_list.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "proto/model/scene.hpp"

namespace fanlight {
namespace {

const std::string kLasso =
    "inside -3000 45.5 from 0 10 0 right 1 0 0 up 0 0 1 eye 0 outline -5 -5 5 -5 0 7.25";
const std::string kBalls = "balls 4 at 1 2 3 -4.5 5 6";

TEST(CutListTest, HoldsLassosAndBalls) {
  const auto list = CutList::parse(kLasso + "; " + kBalls + " ;\n ");
  ASSERT_TRUE(list) << list.error().message;
  ASSERT_EQ(list->cuts().size(), 2U);
  const CutList::Cut& lasso = list->cuts()[0];
  EXPECT_EQ(lasso.kind, CutList::Kind::kInside);
  EXPECT_EQ(lasso.nearest_mm, -3000);
  EXPECT_EQ(lasso.farthest_mm, 45.5F);
  EXPECT_EQ(lasso.origin[1], 10);
  ASSERT_EQ(list->numbers(lasso).size(), 6U);
  EXPECT_EQ(list->numbers(lasso)[5], 7.25F);
  const CutList::Cut& balls = list->cuts()[1];
  EXPECT_EQ(balls.kind, CutList::Kind::kBalls);
  EXPECT_EQ(balls.radius_mm, 4);
  EXPECT_EQ(list->numbers(balls)[3], -4.5F);
}

TEST(CutListTest, IsReadBackFromItsText) {
  for (const std::string& text : {std::string(), kLasso, kBalls + "; " + kLasso}) {
    const auto list = CutList::parse(text);
    ASSERT_TRUE(list) << list.error().message;
    EXPECT_EQ(list->text(), text);
    EXPECT_EQ(*CutList::parse(list->text()), *list);
  }
}

TEST(CutListTest, ContinuesAnotherWithFurtherCuts) {
  const CutList none;
  const CutList one = *CutList::parse(kLasso);
  const CutList two = *CutList::parse(kLasso + ";" + kBalls);
  const CutList other = *CutList::parse(kBalls + ";" + kLasso);
  EXPECT_TRUE(one.continues(none));
  EXPECT_TRUE(two.continues(one));
  EXPECT_TRUE(two.continues(two));
  const CutList more = *CutList::parse(kLasso + ";" + kBalls + " 7 8 9");
  EXPECT_TRUE(more.continues(two));
  EXPECT_FALSE(two.continues(more));
  EXPECT_NE(more, two);
  EXPECT_FALSE(one.continues(two));
  EXPECT_FALSE(other.continues(one));
  EXPECT_NE(one, two);
}

TEST(CutListTest, RefusesWhatIsNoCut) {
  const std::string wrong[] = {
      "lasso 1 2 3",
      "inside 0 50",
      "inside 50 0 from 0 0 0 right 1 0 0 up 0 0 1 eye 0 outline 0 0 1 0 0 1",    // ends before it begins
      "inside 0 50 from 0 0 0 right 1 0 0 up 0.5 0 1 eye 0 outline 0 0 1 0 0 1",  // no right angle
      "inside 0 50 from 0 0 0 right 2 0 0 up 0 0 1 eye 0 outline 0 0 1 0 0 1",    // no unit vector
      "inside 0 50 from 0 0 0 right 1 0 0 up 0 0 1 eye -1 outline 0 0 1 0 0 1",
      "inside 0 50 from 0 0 0 right 1 0 0 up 0 0 1 eye 0 outline 0 0 1 0",        // two corners
      "inside 0 50 from 0 0 0 right 1 0 0 up 0 0 1 eye 0 outline 0 0 1 0 0 1 2",  // half a corner
      "inside 0 50 from 0 0 nan right 1 0 0 up 0 0 1 eye 0 outline 0 0 1 0 0 1",
      "inside 0 50 from 0 0 9999 right 1 0 0 up 0 0 1 eye 0 outline 0 0 1 0 0 1",
      "balls 0 at 1 2 3",
      "balls 101 at 1 2 3",
      "balls 4 at 1 2",
      "balls 4 at",
      "balls 4 1 2 3",
      kBalls + ";;" + kBalls,
  };
  for (const std::string& text : wrong) {
    const auto list = CutList::parse(text);
    ASSERT_FALSE(list) << text;
    EXPECT_EQ(list.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(list.error().message.find("expected"), std::string::npos) << list.error().message;
  }
}

TEST(CutListTest, IsBounded) {
  std::string cuts;
  for (std::size_t i = 0; i < CutList::kMostCuts; ++i) cuts += kBalls + ";";
  EXPECT_TRUE(CutList::parse(cuts));
  EXPECT_FALSE(CutList::parse(cuts + kBalls));
  std::string numbers = "balls 4 at";
  for (std::size_t i = 0; i < CutList::kMostNumbers; ++i) numbers += " 1";
  EXPECT_TRUE(CutList::parse(numbers));
  EXPECT_FALSE(CutList::parse(numbers + " 1 2 3"));
  EXPECT_FALSE(CutList::parse(std::string(CutList::kMostText + 1, ' ')));
}

TEST(CutListTest, IsAFieldOfTheScene) {
  const SceneField* const field = find_scene_field("cuts.shapes");
  ASSERT_NE(field, nullptr);
  Scene scene;
  ASSERT_TRUE(set_field(scene, *field, kLasso));
  EXPECT_EQ(field->get_text(scene), kLasso);
  EXPECT_EQ(first_pass_changed(Scene(), scene), FirstPass::kCast);
  const auto refused = set_field(scene, *field, std::string_view("knife"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message.find("cuts.shapes: cut 1 cannot be read, expected"), 0U)
      << refused.error().message;
}

}  // namespace
}  // namespace fanlight
