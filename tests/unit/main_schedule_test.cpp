// SPDX-License-Identifier: Apache-2.0
// The order of the main view's work, without a GPU: one row of a table per situation.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "renderer/schedule/main_schedule.hpp"

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
const NumberedScene kCoarse = changed(1, [](Scene& scene) { scene.rays.stride = 2; });
const NumberedScene kOtherCoarseView = changed(2, [](Scene& scene) {
  scene.rays.stride = 2;
  scene.camera.yaw_deg += 10;
});
const NumberedScene kRaw = changed(1, [](Scene& scene) { scene.speckle.filter = SpeckleFilter::kNone; });
const NumberedScene kRawLight = changed(2, [](Scene& scene) {
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.light.right_mm += 10;
});
const NumberedScene kRawView = changed(2, [](Scene& scene) {
  scene.speckle.filter = SpeckleFilter::kNone;
  scene.camera.yaw_deg += 10;
});
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
  bool volume_waits = false;
  bool runs_here = false;
};

void PrintTo(const MainCase& row, std::ostream* out) {
  *out << row.name;
}

class MainScheduleTest : public testing::TestWithParam<MainCase> {};

TEST_P(MainScheduleTest, DecidesTheSteps) {
  const MainCase& row = GetParam();
  const MainStatus status{.slots = {row.newest, row.other},
                          .newest = 0,
                          .shown = row.shown,
                          .volume_waits = row.volume_waits,
                          .runs_here = row.runs_here};
  const MainSteps due = decide(status, *row.scene);
  EXPECT_EQ(Steps(due.steps().begin(), due.steps().end()), row.expected);
}

const auto kOutstanding = [](SlotStatus& slot) { slot.outstanding = true; };
const auto kReadPrivately = [](SlotStatus& slot) { slot.read_by_private_view = true; };
const auto kAllBands = [](SlotStatus& slot) { slot.cast_submitted = true; };
const auto kGaveUp = [](SlotStatus& slot) { slot.gave_up_cast = true; };
const auto kChangedFrames = [](SlotStatus& slot) { slot.frames_changed = true; };
const auto kStaged = [](SlotStatus& slot) { slot.frames_staged = true; };
const auto kLate = [](SlotStatus& slot) { slot.cast_nearly_submitted = true; };
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
    {"where the processor runs both, the piece alone",
     casting(),
     filtering(false),
     0,
     &kBase,
     {kLightPieceOfOther},
     false,
     true},
    {"nor does it prepare frames between two pieces",
     filtering(false),
     at_rest(),
     1,
     &kBase,
     {kLightPiece},
     false,
     true},
    {"nor between two bands",
     with(casting(kRaw), kLate),
     with(at_rest(kRaw), kStaged),
     0,
     &kRaw,
     {kCastBand},
     true,
     true},
    {"but a light that moves without rest does not stop the cast",
     casting(),
     at_rest(),
     1,
     &kOtherLight,
     {kLightShown, kCastBand},
     false,
     true},
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
    {"early in a cast, a volume waits",
     casting(kRaw),
     with(at_rest(kRaw), kStaged),
     0,
     &kRaw,
     {kCastBand},
     true},
    {"late in a cast, a volume waits",
     with(casting(kRaw), kLate),
     with(at_rest(kRaw), kStaged),
     0,
     &kRaw,
     {kPrepareAhead, kCastBand},
     true},
    {"late in a cast, frames are staged and no volume waits",
     with(casting(kRaw), kLate),
     with(at_rest(kRaw), kStaged),
     0,
     &kRaw,
     {kCastBand}},
    {"late in a cast, a volume waits, and none of its frames is staged",
     with(casting(kRaw), kLate),
     at_rest(kRaw),
     0,
     &kRaw,
     {kCastBand},
     true},
    {"late in a cast, a volume waits, with a speckle filter",
     with(casting(), kLate),
     with(at_rest(), kStaged),
     0,
     &kBase,
     {kCastBand},
     true},
    {"during a band, a volume waits",
     with(with(casting(kRaw), kLate), kOutstanding),
     with(at_rest(kRaw), kStaged),
     0,
     &kRaw,
     {},
     true},
    {"late in a cast, frames of the volume that waits are being prepared",
     with(casting(kRaw), kLate),
     with(with(at_rest(kRaw), kStaged), kOutstanding),
     0,
     &kRaw,
     {kCastBand},
     true},
    {"late in a cast, a volume waits, and the light of its slot changed",
     with(casting(kRaw), kLate),
     with(at_rest(kRaw), kStaged),
     1,
     &kRawLight,
     {kLightShown, kCastBand},
     true},
    {"the last band is done, a volume waits",
     with(with(casting(kRaw), kLate), kAllBands),
     with(at_rest(kRaw), kStaged),
     0,
     &kRaw,
     {kLightCast},
     true},
    {"late in a cast, a volume waits, and the view changed",
     with(casting(kRaw), kLate),
     with(at_rest(kRaw), kStaged),
     0,
     &kRawView,
     {kRestartCast, kCastBand},
     true},
    {"after a cast, a volume waits, and the view changed",
     with(with(at_rest(kRaw), kLate), kAllBands),
     with(at_rest(kRaw), kStaged),
     0,
     &kRawView,
     {kBeginCast, kCastBand},
     true},
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
    {"a view that changed during a coarse cast",
     casting(kCoarse),
     at_rest(kOtherCoarseView),
     1,
     &kOtherCoarseView,
     {kCastBand}},
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
    {"replacing frames, late in a cast",
     with(casting(kReplacing), kLate),
     with(at_rest(), kStaged),
     0,
     &kReplacing,
     {kCastBand}},
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
  bool runs_here = false;
};

void PrintTo(const AcceptCase& row, std::ostream* out) {
  *out << row.name;
}

class AcceptTest : public testing::TestWithParam<AcceptCase> {};

TEST_P(AcceptTest, DecidesWhatCanBeTaken) {
  const AcceptCase& row = GetParam();
  const MainStatus status{
      .slots = {row.newest, row.other}, .newest = 0, .shown = 0, .runs_here = row.runs_here};
  EXPECT_EQ(accepts_volume(status, *row.scene), row.volume);
  EXPECT_EQ(accepts_frame(status, *row.scene), row.frame);
}

const AcceptCase kAcceptCases[] = {
    {"before the first volume", empty(), empty(), &kBase, true, false},
    {"at rest", at_rest(), at_rest(), &kBase, true, true},
    {"the newest is lit, the other slot is free", lighting(), at_rest(), &kBase, true, true},
    {"the processor is filtering the newest", filtering(false), at_rest(), &kBase, false, true, true},
    {"the processor has lit the newest", with(at_rest(), kOutstanding), at_rest(), &kBase, true, true, true},
    {"the newest is cast", casting(), at_rest(), &kBase, false, true},
    {"the other slot is lit", at_rest(), lighting(), &kBase, false, false},
    {"the other slot is being prepared", at_rest(), with(at_rest(), kOutstanding), &kBase, false, false},
    {"a private view reads the other slot", at_rest(), with(at_rest(), kReadPrivately), &kBase, false, false},
    {"replacing frames", at_rest(kReplacing), at_rest(), &kReplacing, true, true},
    {"replacing frames, the newest is lit", lighting(kReplacing), at_rest(), &kReplacing, false, false},
    {"replacing frames, the other slot is lit", at_rest(kReplacing), lighting(), &kReplacing, false, true},
};

INSTANTIATE_TEST_SUITE_P(Situations, AcceptTest, testing::ValuesIn(kAcceptCases));

TEST(StaysQueuedTest, WhatBelongsToAVolumeAfterTheOneThatWaits) {
  EXPECT_FALSE(stays_queued(7, std::nullopt, false));
  EXPECT_FALSE(stays_queued(7, 7, false));
  EXPECT_TRUE(stays_queued(8, 7, false));
  EXPECT_TRUE(stays_queued(7, 7, true)) << "frames that replace those of the last volume";
  EXPECT_FALSE(stays_queued(7, std::nullopt, true));
}

}  // namespace
}  // namespace fanlight::test
