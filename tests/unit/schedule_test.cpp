// SPDX-License-Identifier: Apache-2.0
// The order of the renderer's work, without a GPU: one row of a table per situation.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "renderer/schedule/main_schedule.hpp"
#include "renderer/schedule/private_schedule.hpp"

namespace fanlight::test {
namespace {

NumberedScene changed(std::uint64_t revision, void (*change)(Scene&)) {
  NumberedScene scene{.revision = revision, .scene = {}};
  change(scene.scene);
  return scene;
}

const NumberedScene kBase{.revision = 1, .scene = {}};
const NumberedScene kNewRevision{.revision = 2, .scene = {}};
const NumberedScene kOtherLight = changed(2, [](Scene& scene) { scene.light.right_mm += 10; });
const NumberedScene kOtherView = changed(2, [](Scene& scene) { scene.camera.yaw_deg += 10; });
const NumberedScene kReplacing = changed(1, [](Scene& scene) { scene.refresh = Refresh::kFrame; });

/// A slot that shows kBase and has nothing to do.
SlotStatus at_rest(const NumberedScene& scene = kBase) {
  return {.loaded = true, .cast_submitted = true, .cast_scene = &scene, .lit_scene = &scene};
}

SlotStatus casting(const NumberedScene& scene = kBase) {
  SlotStatus slot = at_rest(scene);
  slot.phase = WorkPhase::kCasting;
  slot.cast_submitted = false;
  return slot;
}

SlotStatus lighting(const NumberedScene& scene = kBase) {
  SlotStatus slot = at_rest(scene);
  slot.phase = WorkPhase::kLighting;
  slot.outstanding = true;
  return slot;
}

/// A piece of the filter is under way on the device of passes 2 and 3, or done.
SlotStatus filtering(bool under_way) {
  SlotStatus slot = lighting();
  slot.light_begun = slot.light_submitted = false;
  slot.outstanding = slot.light_outstanding = under_way;
  return slot;
}

SlotStatus empty() {
  return {.cast_scene = &kBase, .lit_scene = &kBase};
}

template <typename Change>
SlotStatus with(SlotStatus slot, Change change) {
  change(slot);
  return slot;
}

using Steps = std::vector<MainStep>;
using enum MainStep;

/// Slot 0 is the newest one.
struct MainCase {
  const char* name;
  SlotStatus newest;
  SlotStatus other;
  std::size_t shown;
  const NumberedScene* scene;
  Steps expected;
};

void PrintTo(const MainCase& row, std::ostream* out) {
  *out << row.name;
}

class MainScheduleTest : public testing::TestWithParam<MainCase> {};

TEST_P(MainScheduleTest, DecidesTheSteps) {
  const MainCase& row = GetParam();
  const MainStatus status{.slots = {row.newest, row.other}, .newest = 0, .shown = row.shown};
  const MainSteps due = decide(status, *row.scene);
  EXPECT_EQ(Steps(due.steps().begin(), due.steps().end()), row.expected);
}

const auto kOutstanding = [](SlotStatus& slot) { slot.outstanding = true; };
const auto kReadPrivately = [](SlotStatus& slot) { slot.read_by_private_view = true; };
const auto kAllBands = [](SlotStatus& slot) { slot.cast_submitted = true; };
const auto kGaveUp = [](SlotStatus& slot) { slot.gave_up_cast = true; };
const auto kChangedFrames = [](SlotStatus& slot) { slot.frames_changed = true; };
const auto kMendable = [](SlotStatus& slot) { slot.frames_changed = slot.can_recast = true; };

const MainCase kMainCases[] = {
    {"before the first volume", empty(), empty(), 0, &kBase, {}},
    {"at rest, frames of the next volume may be prepared", at_rest(), at_rest(), 0, &kBase, {kPrepareAhead}},
    {"at rest, the other slot is still being lit", at_rest(), lighting(), 0, &kBase, {}},
    {"at rest, a private view reads the other slot",
     at_rest(),
     with(at_rest(), kReadPrivately),
     0,
     &kBase,
     {}},
    {"frames are being prepared ahead", at_rest(), with(at_rest(), kOutstanding), 0, &kBase, {}},

    {"a changed light", at_rest(), at_rest(), 0, &kOtherLight, {kLightShown, kPrepareAhead}},
    {"a new revision of the same scene",
     at_rest(),
     at_rest(),
     0,
     &kNewRevision,
     {kLightShown, kPrepareAhead}},
    {"a changed light while the last light is under way",
     lighting(),
     at_rest(),
     0,
     &kOtherLight,
     {kPrepareAhead}},
    {"a changed light of the older volume during a cast",
     casting(),
     at_rest(),
     1,
     &kOtherLight,
     {kLightShown, kCastBand}},
    {"a changed light of the older volume during a band",
     with(casting(), kOutstanding),
     at_rest(),
     1,
     &kOtherLight,
     {kLightShown}},
    {"a changed light, the next one filtered", filtering(true), at_rest(), 1, &kOtherLight, {kLightShown}},
    {"a changed light between two pieces of the filter",
     filtering(false),
     at_rest(),
     1,
     &kOtherLight,
     {kLightShown, kLightPiece}},
    {"a changed light, the next one lit", lighting(), at_rest(), 1, &kOtherLight, {kPrepareAhead}},
    {"the next piece of the filter", filtering(false), at_rest(), 1, &kBase, {kLightPiece, kPrepareAhead}},
    {"the next piece of the older volume, beside a cast",
     casting(),
     filtering(false),
     0,
     &kBase,
     {kLightPieceOfOther, kCastBand}},
    {"no piece goes before the older volume's", filtering(false), filtering(true), 1, &kBase, {}},
    {"nor does a finished cast", with(casting(), kAllBands), filtering(true), 1, &kBase, {}},
    {"a changed light although a private view reads the slot",
     with(at_rest(), kReadPrivately),
     at_rest(),
     0,
     &kOtherLight,
     {kLightShown, kPrepareAhead}},

    {"a changed view", at_rest(), at_rest(), 0, &kOtherView, {kBeginCast, kCastBand}},
    {"a changed view while a private view reads the slot",
     with(at_rest(), kReadPrivately),
     at_rest(),
     0,
     &kOtherView,
     {kPrepareAhead}},
    {"a changed view while the picture is under way", lighting(), at_rest(), 0, &kOtherView, {kPrepareAhead}},
    {"a changed view before the first volume", empty(), empty(), 0, &kOtherView, {}},

    {"the next band", casting(), at_rest(), 1, &kBase, {kCastBand}},
    {"a band is outstanding", with(casting(), kOutstanding), at_rest(), 1, &kBase, {}},
    {"the last band is done", with(casting(), kAllBands), at_rest(), 1, &kBase, {kLightCast}},
    {"the last band is outstanding",
     with(with(casting(), kAllBands), kOutstanding),
     at_rest(),
     1,
     &kBase,
     {}},

    {"a view that changed during a cast",
     casting(),
     at_rest(kOtherView),
     1,
     &kOtherView,
     {kRestartCast, kCastBand}},
    {"a view that changed during a band",
     with(casting(), kOutstanding),
     at_rest(kOtherView),
     1,
     &kOtherView,
     {}},
    {"a view that changed again after a restart",
     with(casting(), kGaveUp),
     at_rest(kOtherView),
     1,
     &kOtherView,
     {kCastBand}},
    {"a view that changed after the last band",
     with(casting(), kAllBands),
     at_rest(kOtherView),
     1,
     &kOtherView,
     {kLightCast}},

    {"replacing frames, at rest", at_rest(kReplacing), at_rest(), 0, &kReplacing, {}},
    {"replacing frames, a frame came",
     with(at_rest(kReplacing), kMendable),
     at_rest(),
     0,
     &kReplacing,
     {kRecast}},
    {"replacing frames, a frame that needs a whole cast",
     with(at_rest(kReplacing), kChangedFrames),
     at_rest(),
     0,
     &kReplacing,
     {kBeginCast}},
    {"replacing frames, a frame came while the picture is under way",
     with(lighting(kReplacing), kMendable),
     at_rest(),
     0,
     &kReplacing,
     {}},
    {"replacing frames, a private view reads the slot",
     with(with(at_rest(kReplacing), kMendable), kReadPrivately),
     at_rest(),
     0,
     &kReplacing,
     {}},
    {"replacing frames, the tiles are being cast",
     with(with(casting(kReplacing), kAllBands), kOutstanding),
     at_rest(),
     0,
     &kReplacing,
     {}},
    {"replacing frames, the tiles are cast",
     with(casting(kReplacing), kAllBands),
     at_rest(),
     0,
     &kReplacing,
     {kLightCast}},
    {"frames are no longer replaced",
     with(at_rest(kReplacing), kMendable),
     at_rest(),
     0,
     &kBase,
     {kLightShown, kPrepareAhead}},
};

INSTANTIATE_TEST_SUITE_P(Situations, MainScheduleTest, testing::ValuesIn(kMainCases));

struct AcceptCase {
  const char* name;
  SlotStatus newest;
  SlotStatus other;
  const NumberedScene* scene;
  bool volume;
  bool frame;
};

void PrintTo(const AcceptCase& row, std::ostream* out) {
  *out << row.name;
}

class AcceptTest : public testing::TestWithParam<AcceptCase> {};

TEST_P(AcceptTest, DecidesWhatCanBeTaken) {
  const AcceptCase& row = GetParam();
  const MainStatus status{.slots = {row.newest, row.other}, .newest = 0, .shown = 0};
  EXPECT_EQ(accepts_volume(status, *row.scene), row.volume);
  EXPECT_EQ(accepts_frame(status, *row.scene), row.frame);
}

const AcceptCase kAcceptCases[] = {
    {"before the first volume", empty(), empty(), &kBase, true, false},
    {"at rest", at_rest(), at_rest(), &kBase, true, true},
    {"the newest is lit, the other slot is free", lighting(), at_rest(), &kBase, true, true},
    {"the newest is cast", casting(), at_rest(), &kBase, false, true},
    {"the other slot is lit", at_rest(), lighting(), &kBase, false, false},
    {"the other slot is being prepared", at_rest(), with(at_rest(), kOutstanding), &kBase, false, false},
    {"a private view reads the other slot", at_rest(), with(at_rest(), kReadPrivately), &kBase, false, false},
    {"replacing frames", at_rest(kReplacing), at_rest(), &kReplacing, true, true},
    {"replacing frames, the newest is lit", lighting(kReplacing), at_rest(), &kReplacing, false, false},
    {"replacing frames, the other slot is lit", at_rest(kReplacing), lighting(), &kReplacing, false, true},
};

INSTANTIATE_TEST_SUITE_P(Situations, AcceptTest, testing::ValuesIn(kAcceptCases));

const ShownStatus kShown{.frames_ready = true, .volume_id = 5, .frames_version = 3, .cast_number = 7};
const Scene kScene;
const Scene kTurned = kOtherView.scene;

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
}  // namespace fanlight::test
