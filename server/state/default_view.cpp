// SPDX-License-Identifier: Apache-2.0
#include "server/state/default_view.hpp"

#include "server/state/scene_message.hpp"

namespace fanlight {

DefaultView::DefaultView(bool wanted, SceneStore& scene_store, SurveyDesk& surveys)
    : wanted_(wanted),
      scene_store_(scene_store),
      surveys_(surveys),
      for_source_(scene_store.suggested()),
      own_revision_(scene_store.in_force().revision) {}

void DefaultView::picture_shown(std::int64_t now_ns) {
  if (!wanted_ || found_ || now_ns < next_ns_ || !untouched()) return;
  if (surveys_.look(for_source_)) next_ns_ = now_ns + kBetweenNs;
}

bool DefaultView::answered(const v1::SurveyReply& reply) {
  if (!untouched()) return false;
  if (!reply.has_found()) {
    note_ = reply.refused().message() + "; the server looks again until it finds one";
    Scene slices = for_source_;
    slices.mode = Mode::kSlices;
    return suggest(slices);
  }
  const auto scene = changed_scene(for_source_, reply.found().scene());
  if (!scene) return false;
  found_ = true;
  note_ = "nobody chose a view, so the server looked for the surface and found " +
          (reply.found().choices().empty() ? "one" : reply.found().choices(0));
  return suggest(*scene);
}

bool DefaultView::source_changed(const Scene& suggested) {
  if (!untouched()) return scene_store_.suggest(suggested);
  for_source_ = suggested;
  found_ = false;
  next_ns_ = 0;
  note_.clear();
  return suggest(suggested);
}

bool DefaultView::suggest(const Scene& scene) {
  const bool differs = scene_store_.suggest(scene);
  own_revision_ = scene_store_.in_force().revision;
  return differs;
}

}  // namespace fanlight
