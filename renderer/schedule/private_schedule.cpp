// SPDX-License-Identifier: Apache-2.0
#include "renderer/schedule/private_schedule.hpp"

namespace fanlight {

namespace {

bool is_due(const PrivateStatus& view, const ShownStatus& shown) {
  if (view.wanted_view_id == 0) return false;
  if (view.volume_id != shown.volume_id) return true;
  if (!view.drawn || view.revision != view.wanted_revision || !view.of_shown_slot) return true;
  return view.own_camera ? view.cast_number != 0 || view.frames_version != shown.frames_version
                         : view.cast_number != shown.cast_number;
}

bool is_under_way(const PrivateStatus& view) {
  return view.phase == WorkPhase::kCasting || (view.phase == WorkPhase::kLighting && !view.light_submitted);
}

PrivateStep first_step(const PrivateStatus& view, const ShownStatus& shown) {
  const bool has_picture = view.drawn && view.of_shown_slot;
  if (!view.own_camera) {
    return has_picture && view.cast_number == shown.cast_number ? PrivateStep::kRelight
                                                                : PrivateStep::kLightShared;
  }
  const bool keeps_cast = has_picture && view.cast_number == 0 &&
                          view.frames_version == shown.frames_version &&
                          first_pass_changed(*view.scene, *view.wanted_scene) > FirstPass::kCast;
  return keeps_cast ? PrivateStep::kRelight : PrivateStep::kBeginCast;
}

/// Continues or gives up the picture under way. One whose inputs are lost, or of a view that was closed,
/// gives way to what is requested now.
PrivateAction continued(const PrivateStatus& view, const ShownStatus& shown) {
  const bool closed = view.wanted_view_id != view.view_id;
  if (!view.inputs_lost && !closed) {
    if (view.phase == WorkPhase::kLighting) return {.step = PrivateStep::kLightPiece};
    return {.step = view.cast_submitted ? PrivateStep::kLightCast : PrivateStep::kCastBand};
  }
  PrivateStatus without_picture = view;
  without_picture.drawn = false;
  return {.step = view.wanted_view_id == 0 ? PrivateStep::kDrop : first_step(without_picture, shown),
          .gives_up = true};
}

}  // namespace

std::optional<PrivateAction> decide(std::span<const PrivateStatus> views, std::size_t first_view,
                                    const ShownStatus& shown) {
  if (!shown.frames_ready) return std::nullopt;
  const auto due = [&](std::size_t index, PrivateAction action) {
    action.view = index;
    action.next_view = (index + 1) % views.size();
    return action;
  };
  for (std::size_t index = 0; index < views.size(); ++index) {
    if (is_under_way(views[index])) return due(index, continued(views[index], shown));
  }
  for (std::size_t offset = 0; offset < views.size(); ++offset) {
    const std::size_t index = (first_view + offset) % views.size();
    const PrivateStatus& view = views[index];
    if (view.phase == WorkPhase::kIdle && is_due(view, shown))
      return due(index, {.step = first_step(view, shown)});
  }
  return std::nullopt;
}

}  // namespace fanlight
