// SPDX-License-Identifier: Apache-2.0
#include "server/state/default_view.hpp"

#include <spdlog/spdlog.h>

#include "server/state/scene_message.hpp"

namespace fanlight {

DefaultView::DefaultView(bool wanted, SceneStore& scene_store, SurveyDesk& surveys,
                         std::vector<std::string>& notes)
    : wanted_(wanted),
      scene_store_(scene_store),
      surveys_(surveys),
      for_source_(scene_store.suggested()),
      own_revision_(scene_store.in_force().revision),
      notes_(notes),
      source_notes_(notes.size()) {}

void DefaultView::picture_shown(std::int64_t now_ns) {
  if (!wanted_ || found_ || now_ns < next_ns_ || !untouched()) return;
  if (surveys_.look(for_source_)) next_ns_ = now_ns + kBetweenNs;
}

bool DefaultView::answered(const v1::SurveyReply& reply) {
  if (!untouched()) return false;
  if (!reply.has_found()) {
    note(reply.refused().message() + "; the server looks again until it finds one");
    Scene slices = for_source_;
    slices.mode = Mode::kSlices;
    return suggest(slices);
  }
  const auto scene = changed_scene(for_source_, reply.found().scene());
  if (!scene) return false;
  found_ = true;
  note("nobody chose a view, so the server looked for the surface and found " +
       (reply.found().choices().empty() ? "one" : reply.found().choices(0)));
  for (int i = 1; i < reply.found().choices_size(); ++i) spdlog::info("view: {}", reply.found().choices(i));
  return suggest(*scene);
}

bool DefaultView::source_changed(const Scene& suggested) {
  if (!untouched()) return scene_store_.suggest(suggested);
  for_source_ = suggested;
  found_ = false;
  next_ns_ = 0;
  notes_.resize(source_notes_);
  return suggest(suggested);
}

void DefaultView::note(const std::string& sentence) {
  if (notes_.size() > source_notes_ && notes_.back() == sentence) return;
  notes_.resize(source_notes_);
  notes_.push_back(sentence);
  spdlog::info("{}", sentence);
}

bool DefaultView::suggest(const Scene& scene) {
  const bool differs = scene_store_.suggest(scene);
  own_revision_ = scene_store_.in_force().revision;
  return differs;
}

}  // namespace fanlight
