// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/main_schedule.hpp"

#include <algorithm>

namespace fanlight {

namespace {

bool idle_and_settled(const SlotStatus& slot) {
  return slot.phase == WorkPhase::kIdle && slot.settled();
}

bool replaces_frames(const MainStatus& status, const NumberedScene& scene) {
  const SlotStatus& newest = status.slots[status.newest];
  return fanlight::replaces_frames(newest.loaded, *newest.cast_scene, scene);
}

/// Where volumes come faster than casts, the frames of the volume that waits are prepared between two bands,
/// so that its pass 1 starts when this cast ends, at the same time as passes 2 and 3. (Where the processor
/// runs all of them, one after the other, that is of no use.) This delays the cast by
/// pass 0, and is wasted where a newer volume completes before the cast ends: so it is done late in the cast,
/// and only without a speckle filter: on a GPU pass 0 takes longer than pass 1 with one.
bool prepares_between_bands(const MainStatus& status, const NumberedScene& scene) {
  return !status.runs_here && status.volume_waits && status.slots[status.newest].cast_nearly_submitted &&
         status.slots[status.other()].frames_staged && scene.scene.speckle.filter == SpeckleFilter::kNone &&
         !replaces_frames(status, scene) && accepts_frame(status, scene);
}

}  // namespace

bool view_changed(const NumberedScene& cast_scene, const NumberedScene& scene) {
  return first_pass_changed(cast_scene.scene, scene.scene) <= FirstPass::kCast;
}

bool differs_in_size_alone(const Scene& from, const Scene& to) {
  if (from.size == to.size) return false;
  Scene same_size = to;
  same_size.size = from.size;
  return first_pass_changed(from, same_size) > FirstPass::kCast;
}

bool light_changed(const SlotStatus& slot, const NumberedScene& scene) {
  // With the view unchanged every new revision gets its picture, even one that returns to what is shown: the
  // client that sent it waits for a picture with its number.
  if (!view_changed(*slot.cast_scene, scene) && slot.lit_scene->revision != scene.revision) return true;
  const Scene possible = relit(slot.cast_scene->scene, scene.scene);
  return first_pass_changed(slot.lit_scene->scene, possible) != FirstPass::kNone;
}

bool replaces_frames(bool loaded, const NumberedScene& cast_scene, const NumberedScene& scene) {
  return scene.scene.refresh == Refresh::kFrame && loaded && cast_scene.scene.refresh == Refresh::kFrame;
}

bool may_average(const MappedVolume& map, const MappedVolume& now) {
  if (map.id == 0) return false;
  if (map.id == now.id) return true;
  // A display may freeze a volume when the renderer has one or two newer ones.
  constexpr std::uint64_t kNewer = 2;
  return !map.is_kept && map.id < now.id + (now.is_kept ? kNewer + 1 : 0);
}

bool gives_way(const SlotStatus& slot) {
  return slot.phase == WorkPhase::kCasting && slot.refines && !slot.cast_submitted && slot.settled();
}

bool accepts_volume(const MainStatus& status, const NumberedScene& scene) {
  const bool casting = std::ranges::any_of(status.slots, [](const SlotStatus& slot) {
    return slot.phase == WorkPhase::kCasting && !gives_way(slot);
  });
  const bool lighting = std::ranges::any_of(status.slots, [&](const SlotStatus& slot) {
    return status.runs_here && slot.phase == WorkPhase::kLighting && !slot.light_submitted;
  });
  if (casting || lighting || !idle_and_settled(status.slots[status.other()])) return false;
  // Where frames are replaced, a volume may take either slot.
  return !replaces_frames(status, scene) || idle_and_settled(status.slots[status.newest]);
}

bool accepts_frame(const MainStatus& status, const NumberedScene& scene) {
  const std::size_t target = replaces_frames(status, scene) ? status.newest : status.other();
  return status.slots[status.newest].loaded && idle_and_settled(status.slots[target]);
}

bool stays_queued(std::uint64_t commit_number, std::optional<std::uint64_t> waiting_commit_number,
                  bool replaces_frames) {
  return waiting_commit_number && (replaces_frames || commit_number > *waiting_commit_number);
}

MainSteps decide(const MainStatus& status, const NumberedScene& scene) {
  MainSteps due;
  MainStatus now = status;  // as the steps so far leave it
  SlotStatus& newest = now.slots[now.newest];

  // A cast whose view is outdated is restarted between two bands, but not twice in a row: a camera that never
  // rests must not starve the pictures. A coarse one ends soon, and is shown on the way.
  const bool begin = idle_and_settled(newest) && newest.loaded && view_changed(*newest.cast_scene, scene);
  const bool is_coarse = newest.cast_scene->scene.rays.stride > 1;
  const bool restart = newest.phase == WorkPhase::kCasting && !newest.cast_submitted && !newest.outstanding &&
                       !newest.gave_up_cast && !is_coarse && view_changed(*newest.cast_scene, scene);
  if (begin || restart) {
    due.add(begin ? MainStep::kBeginCast : MainStep::kRestartCast);
    newest.phase = WorkPhase::kCasting;
    newest.cast_submitted = newest.cast_nearly_submitted = false;
  }

  // Before the next band, so that a changed light does not wait for the band. Not where the next picture will
  // be shown in a moment: it would come first, or show the old light after the new one.
  SlotStatus& shown = now.slots[now.shown];
  const bool next_is_lit =
      now.shown != now.newest && newest.phase == WorkPhase::kLighting && newest.light_begun;
  if (shown.phase == WorkPhase::kIdle && shown.loaded && !shown.map_lost && !next_is_lit &&
      light_changed(shown, scene)) {
    due.add(MainStep::kLightShown);
    shown.phase = WorkPhase::kLighting;
    shown.light_submitted = true;  // its first piece; the next one is for the next call
  }
  const auto piece_is_due = [](const SlotStatus& slot) {
    return slot.phase == WorkPhase::kLighting && !slot.light_submitted && !slot.light_outstanding;
  };
  if (piece_is_due(now.slots[now.other()])) due.add(MainStep::kLightPieceOfOther);
  // Pictures are shown in the order of their volumes: no piece of the newer one goes before the last
  // piece of the older one.
  const SlotStatus& older = now.slots[now.other()];
  const bool older_is_submitted = older.phase != WorkPhase::kLighting || older.light_submitted;
  if (older_is_submitted && piece_is_due(newest)) due.add(MainStep::kLightPiece);

  // On the same threads other work would only delay the picture that is nearly done.
  const bool light_goes_first = now.runs_here && std::ranges::any_of(now.slots, piece_is_due);
  const bool replaces = replaces_frames(status, scene);
  if (light_goes_first) return due;
  if (replaces && idle_and_settled(newest) && newest.frames_changed) {
    due.add(newest.can_recast ? MainStep::kRecast : MainStep::kBeginCast);
  } else if (newest.phase == WorkPhase::kCasting) {
    // A band waits until the band before it is done, and the light waits for the last band: work that is
    // submitted early delays a changed light, or shows an old one.
    const MainStep next = newest.cast_submitted ? MainStep::kLightCast : MainStep::kCastBand;
    if (!newest.outstanding && next == MainStep::kCastBand && prepares_between_bands(now, scene))
      due.add(MainStep::kPrepareAhead);
    if (!newest.outstanding && (next == MainStep::kCastBand || older_is_submitted)) due.add(next);
  } else if (!replaces && accepts_frame(now, scene)) {
    due.add(MainStep::kPrepareAhead);
  }
  return due;
}

}  // namespace fanlight
