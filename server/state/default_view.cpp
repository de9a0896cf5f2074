// SPDX-License-Identifier: Apache-2.0
#include "server/state/default_view.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

bool same(const Scene& a, const Scene& b) {
  return std::ranges::all_of(scene_fields(), [&](const SceneField& field) { return field.same(a, b); });
}

}  // namespace

DefaultView::DefaultView(bool wanted, SceneStore& scene_store, SurveyDesk& surveys,
                         std::vector<std::string>& notes)
    : wanted_(wanted),
      scene_store_(scene_store),
      surveys_(surveys),
      for_source_(scene_store.suggested()),
      own_revision_(scene_store.in_force().revision),
      notes_(notes),
      source_notes_(notes.size()) {}

void DefaultView::picture_shown(const PictureStamp& stamp, std::int64_t now_ns) {
  if (!wanted_ || found_ || looking_ || now_ns < next_ns_ || !untouched()) return;
  if (stamp.volume.first_capture_time_ns < captured_from_ns_) return;
  looking_ = surveys_.look(for_source_);
  if (looking_) next_ns_ = now_ns + kBetweenNs;
}

bool DefaultView::answered(const SurveyDesk::Answer& answer) {
  looking_ = false;
  if (std::exchange(outdated_, false) || !untouched()) return false;
  using Outcome = SurveyDesk::Outcome;
  if (answer.outcome == Outcome::kNoSurface) {
    if (is_unsure_) return false;  // a torn sheet is better than none
    Scene slices = for_source_;
    slices.mode = Mode::kSlices;
    return suggest(
        slices,
        "no view was chosen, and no surface was found in the volume: showing its slices, and looking again "
        "until the scene is changed");
  }
  if (answer.outcome != Outcome::kFound) return false;  // it looks again
  const auto& found = answer.reply.found();
  auto scene = changed_scene(for_source_, found.scene());
  if (!scene) return false;
  found_ = !found.unsure();
  // Another torn sheet is no better, and the view would move.
  if (found.unsure() && std::exchange(is_unsure_, true)) return false;
  if (found.unsure()) scene->mode = Mode::kSlices;
  std::string sentence = "no view was chosen, so the server looked for the surface and found " +
                         (found.choices().empty() ? "one" : found.choices(0));
  if (found.unsure())
    sentence +=
        ". It is small or torn: slices are shown beside it, and the server looks again until the scene is "
        "changed";
  const bool differs = suggest(*scene, sentence);
  for (int i = 1; i < found.choices_size(); ++i) spdlog::info("view: {}", found.choices(i));
  return differs;
}

bool DefaultView::source_changed(const Scene& suggested, std::int64_t now_ns) {
  if (same(suggested, for_source_)) return false;
  for_source_ = suggested;
  const bool touched = !untouched();
  outdated_ = looking_;
  found_ = is_unsure_ = false;
  next_ns_ = 0;
  captured_from_ns_ = now_ns;
  const bool noted = notes_.size() > source_notes_;
  notes_.resize(source_notes_);
  const auto differs = scene_store_.suggest(suggested);
  if (!touched) own_revision_ = scene_store_.in_force().revision;
  return noted || (differs && *differs);
}

bool DefaultView::suggest(const Scene& scene, const std::string& sentence) {
  const auto differs = scene_store_.suggest(scene);
  own_revision_ = scene_store_.in_force().revision;
  if (!differs)
    return note("no view was chosen, but the one found contradicts the options: " + differs.error().message);
  const bool noted = note(sentence);
  return noted || *differs;
}

bool DefaultView::note(const std::string& sentence) {
  if (notes_.size() > source_notes_ && notes_.back() == sentence) return false;
  notes_.resize(source_notes_);
  notes_.push_back(sentence);
  spdlog::info("{}", sentence);
  return true;
}

}  // namespace fanlight
