// SPDX-License-Identifier: Apache-2.0
// The order of the work for private views, without a GPU: one row of a table per situation.
#include <gtest/gtest.h>

#include <array>
#include <optional>
#include <ostream>
#include <utility>
#include <vector>

#include "renderer/schedule/private_schedule.hpp"

namespace fanlight::test::private_schedule_tests {
namespace {

const ShownStatus kShown{.frames_ready = true, .volume_id = 5, .frames_version = 3, .cast_number = 7};
const Scene kScene;
const Scene kTurned = [] {
  Scene scene;
  scene.camera.yaw_deg += 10;
  return scene;
}();

/// A private light that shows what the main view shows.
PrivateStatus light_view() {
  return {.wanted_view_id = 4,
          .wanted_revision = 2,
          .own_camera = false,
          .wanted_scene = &kScene,
          .view_id = 4,
          .revision = 2,
          .volume_id = 5,
          .frames_version = 3,
          .cast_number = 7,
          .scene = &kScene,
          .of_shown_slot = true,
          .drawn = true,
          .cast_submitted = true};
}

/// A private camera that shows the shown volume.
PrivateStatus camera_view() {
  PrivateStatus view = light_view();
  view.own_camera = true;
  view.cast_number = 0;
  return view;
}

PrivateStatus camera_casting() {
  PrivateStatus view = camera_view();
  view.phase = WorkPhase::kCasting;
  view.cast_submitted = false;
  return view;
}

PrivateStatus light_in_pieces() {
  PrivateStatus view = light_view();
  view.phase = WorkPhase::kLighting;
  return view;
}

PrivateStatus no_view() {
  return {.wanted_scene = &kScene, .scene = &kScene};
}

template <typename Change>
PrivateStatus with(PrivateStatus view, Change change) {
  change(view);
  return view;
}

struct PrivateCase {
  const char* name;
  PrivateStatus view;
  std::optional<PrivateStep> expected;
  bool gives_up = false;
};

void PrintTo(const PrivateCase& row, std::ostream* out) {
  *out << row.name;
}

class PrivateScheduleTest : public testing::TestWithParam<PrivateCase> {};

TEST_P(PrivateScheduleTest, DecidesThePieceOfWork) {
  const PrivateCase& row = GetParam();
  const auto action = decide(std::array{row.view}, 0, kShown);
  ASSERT_EQ(action.has_value(), row.expected.has_value());
  if (!action) return;
  EXPECT_EQ(action->step, *row.expected);
  EXPECT_EQ(action->gives_up, row.gives_up);
}

const PrivateCase kPrivateCases[] = {
    {"no view is requested", no_view(), std::nullopt},
    {"a light at rest", light_view(), std::nullopt},
    {"a camera at rest", camera_view(), std::nullopt},
    {"a picture is not collected yet",
     with(light_view(),
          [](PrivateStatus& view) {
            view.phase = WorkPhase::kLighting;
            view.light_submitted = true;
            view.wanted_revision = 3;
          }),
     std::nullopt},

    {"a new light", with(light_view(), [](PrivateStatus& view) { view.drawn = false; }),
     PrivateStep::kLightShared},
    {"a changed light", with(light_view(), [](PrivateStatus& view) { view.wanted_revision = 3; }),
     PrivateStep::kRelight},
    {"a light on the next depth map", with(light_view(), [](PrivateStatus& view) { view.cast_number = 6; }),
     PrivateStep::kLightShared},
    {"a light on the next volume",
     with(light_view(),
          [](PrivateStatus& view) {
            view.volume_id = 4;
            view.cast_number = 6;
            view.of_shown_slot = false;
          }),
     PrivateStep::kLightShared},
    {"a light that was a camera",
     with(light_view(),
          [](PrivateStatus& view) {
            view.cast_number = 0;
            view.wanted_revision = 3;
          }),
     PrivateStep::kLightShared},

    {"a new camera", with(camera_view(), [](PrivateStatus& view) { view.drawn = false; }),
     PrivateStep::kBeginCast},
    {"a camera whose light changed",
     with(camera_view(), [](PrivateStatus& view) { view.wanted_revision = 3; }), PrivateStep::kRelight},
    {"a camera that moved",
     with(camera_view(),
          [](PrivateStatus& view) {
            view.wanted_revision = 3;
            view.wanted_scene = &kTurned;
          }),
     PrivateStep::kBeginCast},
    {"a camera whose frames were replaced",
     with(camera_view(), [](PrivateStatus& view) { view.frames_version = 2; }), PrivateStep::kBeginCast},
    {"a camera on the next volume",
     with(camera_view(),
          [](PrivateStatus& view) {
            view.volume_id = 4;
            view.of_shown_slot = false;
          }),
     PrivateStep::kBeginCast},
    {"a camera that was a light", with(camera_view(), [](PrivateStatus& view) { view.cast_number = 7; }),
     PrivateStep::kBeginCast},

    {"the next band", camera_casting(), PrivateStep::kCastBand},
    {"the last band is done", with(camera_casting(), [](PrivateStatus& view) { view.cast_submitted = true; }),
     PrivateStep::kLightCast},
    {"a cast continues although the main view shows another slot",
     with(camera_casting(), [](PrivateStatus& view) { view.of_shown_slot = false; }), PrivateStep::kCastBand},
    {"a cast continues although its scene changed",
     with(camera_casting(), [](PrivateStatus& view) { view.wanted_revision = 3; }), PrivateStep::kCastBand},
    {"a cast that lost its frames",
     with(camera_casting(), [](PrivateStatus& view) { view.inputs_lost = true; }), PrivateStep::kBeginCast,
     true},
    {"a cast of a view that was closed",
     with(camera_casting(), [](PrivateStatus& view) { view.wanted_view_id = 0; }), PrivateStep::kDrop, true},
    {"a cast of a view that gave way to a private light",
     with(camera_casting(),
          [](PrivateStatus& view) {
            view.wanted_view_id = 9;
            view.own_camera = false;
          }),
     PrivateStep::kLightShared, true},

    {"the next piece of a light", light_in_pieces(), PrivateStep::kLightPiece},
    {"a light continues although it changed",
     with(light_in_pieces(), [](PrivateStatus& view) { view.wanted_revision = 3; }),
     PrivateStep::kLightPiece},
    {"a light continues although the main view shows another slot",
     with(light_in_pieces(), [](PrivateStatus& view) { view.of_shown_slot = false; }),
     PrivateStep::kLightPiece},
    {"a light that lost its depth map",
     with(light_in_pieces(), [](PrivateStatus& view) { view.inputs_lost = true; }), PrivateStep::kLightShared,
     true},
    {"a light of a view that was closed",
     with(light_in_pieces(), [](PrivateStatus& view) { view.wanted_view_id = 0; }), PrivateStep::kDrop, true},
};

INSTANTIATE_TEST_SUITE_P(Situations, PrivateScheduleTest, testing::ValuesIn(kPrivateCases));

TEST(PrivateScheduleOrderTest, DoesNothingWhileTheFramesAreNotReady) {
  ShownStatus shown = kShown;
  shown.frames_ready = false;
  EXPECT_FALSE(decide(std::array{camera_casting()}, 0, shown));
}

TEST(PrivateScheduleOrderTest, TakesTurnsAfterEachPicture) {
  const PrivateStatus due = with(light_view(), [](PrivateStatus& view) { view.wanted_revision = 3; });
  const std::array views = {due, no_view(), due};
  const auto first = decide(views, 0, kShown);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->view, 0U);
  EXPECT_EQ(first->next_view, 1U);
  const auto second = decide(views, first->next_view, kShown);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->view, 2U);
  EXPECT_EQ(second->next_view, 0U);
}

TEST(PrivateScheduleOrderTest, ContinuesAPictureBeforeAnotherViewHasItsTurn) {
  const PrivateStatus new_camera = with(camera_view(), [](PrivateStatus& view) { view.drawn = false; });
  const auto begun = decide(std::array{no_view(), new_camera, new_camera}, 0, kShown);
  ASSERT_TRUE(begun);
  EXPECT_EQ(begun->view, 1U);
  EXPECT_EQ(begun->next_view, 2U);
  const PrivateStatus cast = with(camera_casting(), [](PrivateStatus& view) { view.cast_submitted = true; });
  const std::pair<PrivateStatus, PrivateStep> under_way[] = {{camera_casting(), PrivateStep::kCastBand},
                                                             {cast, PrivateStep::kLightCast},
                                                             {light_in_pieces(), PrivateStep::kLightPiece}};
  for (const auto& [status, step] : under_way) {
    const auto piece = decide(std::array{no_view(), status, new_camera}, begun->next_view, kShown);
    ASSERT_TRUE(piece);
    EXPECT_EQ(piece->view, 1U);
    EXPECT_EQ(piece->step, step);
  }
  const auto next = decide(std::array{no_view(), camera_view(), new_camera}, begun->next_view, kShown);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->view, 2U) << "the other view's turn, once the first is done";
}

}  // namespace
}  // namespace fanlight::test::private_schedule_tests
