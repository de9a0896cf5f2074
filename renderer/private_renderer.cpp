#include "renderer/private_renderer.hpp"

#include <algorithm>
#include <utility>

#include "proto/clock.hpp"

namespace fanlight {

Result<void> PrivateRenderer::want(const PrivateViews& views) {
  for (std::size_t index = 0; index < views.size(); ++index) {
    Place& place = places_[index];
    // Another's pictures begin anew. What is under way for the last one is told apart by collect().
    if (place.wanted.view_id != views[index].view_id) {
      place.drawn = false;
      place.pictures = 0;
    }
    place.wanted = views[index];
    if (place.wanted.view_id == 0 || place.view) continue;
    auto view = VolumeView::create(gpu_, passes_, view_config_);
    if (view) {
      place.view = std::move(*view);
    } else if (view.error().code == ErrorCode::kBroken) {
      return view.error();
    } else {
      // No memory is no reason to end the main view; who waits for this one is told that it had no time.
      place.wanted.view_id = 0;
      counters_.private_views_refused.add();
    }
  }
  return {};
}

bool PrivateRenderer::due(const Place& place, const Shown& shown) const {
  if (place.wanted.view_id == 0) return false;
  if (place.stamp.volume.volume_id != shown.slot.volume().volume_id) return true;
  if (!place.drawn || place.revision != place.wanted.scene.revision || place.slot != &shown.slot) return true;
  return place.wanted.own_camera ? place.cast != 0 || place.frames != shown.slot.frames_turn()
                                 : place.cast != shown.cast;
}

Result<void> PrivateRenderer::begin(Place& place, const Shown& shown) {
  VolumeView& view = *place.view;
  const bool lit_alone = place.cast == shown.cast && place.slot == &shown.slot && place.drawn;
  const bool cast_alone = place.wanted.own_camera && place.cast == 0 && place.slot == &shown.slot &&
                          place.drawn && place.frames == shown.slot.frames_turn() &&
                          first_pass_changed(place.scene, place.wanted.scene.scene) > FirstPass::kCast;
  place.slot = &shown.slot;
  place.frames = shown.slot.frames_turn();
  place.revision = place.wanted.scene.revision;
  place.stamp = {.view_id = place.wanted.view_id,
                 .scene_revision = place.revision,
                 .pass1_runs = counters_.pass1_runs.value(),
                 .pass2_runs = counters_.pass2_runs.value(),
                 .volume = shown.slot.volume()};
  if (!place.wanted.own_camera) {
    place.scene = relit(shown.cast_scene, place.wanted.scene.scene);
    if (!lit_alone) {
      view.share_cast(gpu_, shown.slot.view(), shown.slot.seen());
      view.follow(gpu_, shown.last.view());
    }
    place.cast = shown.cast;
    return light(place, shown.past);
  }
  place.scene = place.wanted.scene.scene;
  place.cast = 0;
  if (cast_alone) return light(place, VolumeView::Past::kNone);
  view.see(gpu_, shown.slot.seen());
  if (auto begun = view.begin_cast(gpu_, passes_, place.scene, shown.slot.seen()); !begun) return begun;
  place.phase = Phase::kCasting;
  counters_.private_casts.add();
  return view.cast_next_band(gpu_, passes_, shown.slot.seen());
}

Result<void> PrivateRenderer::light(Place& place, VolumeView::Past past) {
  place.phase = Phase::kLighting;
  place.stamp.view = picture_view(place.scene, view_config_.size);
  return place.view->light(gpu_, passes_, place.scene, place.slot->seen(), past);
}

Result<void> PrivateRenderer::go_on(Place& place, const Shown& shown) {
  // Frames that have gone, or a view that nobody wants any more.
  const bool lost = place.frames != place.slot->frames_turn() || !place.slot->frames_ready();
  if (lost || place.wanted.view_id != place.stamp.view_id) {
    place.phase = Phase::kIdle;
    place.drawn = false;
    counters_.private_casts_given_up.add();
    return place.wanted.view_id == 0 ? Result<void>{} : begin(place, shown);
  }
  if (place.view->cast_submitted()) return light(place, VolumeView::Past::kNone);
  return place.view->cast_next_band(gpu_, passes_, place.slot->seen());
}

Result<void> PrivateRenderer::advance(const Shown& shown) {
  if (!shown.slot.frames_ready()) return {};
  for (std::size_t turn = 0; turn < places_.size(); ++turn) {
    Place& place = places_[(next_ + turn) % places_.size()];
    if (place.phase == Phase::kIdle && !due(place, shown)) continue;
    // A cast goes on before another begins: the time until its frames are taken may do for one.
    next_ = (next_ + turn) % places_.size();
    auto done = place.phase == Phase::kIdle ? begin(place, shown) : go_on(place, shown);
    if (place.phase != Phase::kCasting) next_ = (next_ + 1) % places_.size();
    return done;
  }
  return {};
}

bool PrivateRenderer::collect() {
  bool any = false;
  for (Place& place : places_) {
    if (place.phase != Phase::kLighting || place.view->outstanding(gpu_) > 0) continue;
    place.phase = Phase::kIdle;
    place.drawn = place.wanted.view_id == place.stamp.view_id;
    if (!place.drawn) continue;
    place.stamp.picture_id = ++place.pictures;
    place.stamp.stage_ms = place.view->stage_ms(gpu_);
    place.stamp.finished_time_ns = now_ns();
    Picture& picture = place.wanted.pictures->draft();
    picture.stamp = place.stamp;
    picture.width = view_config_.size.width;
    picture.height = view_config_.size.height;
    const auto rgba = place.view->picture();
    picture.rgba.assign(rgba.begin(), rgba.end());
    const auto depth_mm = place.view->depth_mm();
    picture.depth_mm.assign(depth_mm.begin(), depth_mm.end());
    place.wanted.pictures->publish();
    counters_.private_pictures.add();
    any = true;
  }
  return any;
}

const VolumeView* PrivateRenderer::under_way() const {
  for (const Place& place : places_) {
    if (place.view && place.view->outstanding(gpu_) > 0) return &*place.view;
  }
  return nullptr;
}

bool PrivateRenderer::reads(const RenderSlot& slot) const {
  return std::ranges::any_of(places_, [&](const Place& place) {
    return place.slot == &slot && place.view && place.view->outstanding(gpu_) > 0;
  });
}

}  // namespace fanlight
