// SPDX-License-Identifier: Apache-2.0
#include "server/state/view_admission.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "server/state/scene_message.hpp"

namespace fanlight {

namespace {

using Groups = std::set<std::string, std::less<>>;

// A picture now and then is better than none: a machine that is busy for a while ends no view.
constexpr double kLeastLightHz = 0.5;
constexpr double kLeastCameraHz = 0.25;
constexpr int kMostSecondsBehind = 5;
// The busy share of the main view covers one second: after this time without a picture, the view is idle.
constexpr double kAtRestMs = 1500;
// The fields that passes 2 and 3 read, and the camera.
constexpr std::string_view kPrivateGroups[] = {"camera",     "filter",   "light",  "fill_light",
                                               "back_light", "material", "shadow", "finish"};

std::string_view group_of(const SceneField& field) {
  return field.name.substr(0, field.name.find('.'));
}

/// `main`, with the fields of `groups` from `own`.
Scene combined(const Scene& main, const Scene& own, const Groups& groups) {
  Scene scene = main;
  for (const SceneField& field : scene_fields()) {
    if (groups.contains(group_of(field))) field.copy(scene, own);
  }
  return scene;
}

/// The groups of the fields that a change holds. Error: a field that a private view cannot have of its own.
Result<Groups> private_groups(const v1::Scene& change) {
  Groups groups;
  const SceneField* not_private = nullptr;
  for_each_change(change, [&](const SceneField& field, const auto& /*value*/) {
    if (std::ranges::find(kPrivateGroups, group_of(field)) == std::end(kPrivateGroups)) not_private = &field;
    groups.emplace(group_of(field));
  });
  if (not_private == nullptr) return groups;
  return Error{
      ErrorCode::kInvalidArgument,
      fmt::format("{} is the main view's, expected fields of camera, filter, light, fill_light, back_light, "
                  "material, shadow or finish",
                  not_private->name)};
}

}  // namespace

void ViewAdmission::StageTimes::note(const std::array<double, kStages>& stage_ms) {
  for (std::size_t stage = 0; stage < kStages; ++stage) {
    if (stage_ms[stage] > 0 && std::exchange(has_run[stage], true)) ms[stage] = stage_ms[stage];
  }
}

ViewAdmission::View* ViewAdmission::find(std::uint64_t session) {
  const auto found = std::ranges::find_if(
      views_, [session](const View& view) { return session != 0 && view.wanted.view_id == session; });
  return found == views_.end() ? nullptr : &*found;
}

double ViewAdmission::cost_ms(const View* view, bool own_camera) const {
  double sum_ms = 0;
  const auto add = [&](Stage stage) {
    const auto index = static_cast<std::size_t>(stage);
    sum_ms += std::max(main_times_.ms[index], view != nullptr ? view->own_times.ms[index] : 0);
  };
  for (const Stage stage : {Stage::kFilter, Stage::kLight, Stage::kFinish, Stage::kReadBack}) add(stage);
  if (own_camera) add(Stage::kCast);
  return sum_ms;
}

bool ViewAdmission::main_at_rest(std::int64_t now_ns) const {
  const double picture_ms = std::accumulate(main_times_.ms.begin(), main_times_.ms.end(), 0.0);
  return static_cast<double>(now_ns - main_shown_ns_) / 1e6 > std::max(kAtRestMs, 2 * picture_ms);
}

double ViewAdmission::left_ms(std::int64_t now_ns) const {
  constexpr double kShare = 1.0 / (1 + kMainTimes);
  const double left_share = main_at_rest(now_ns) ? 1 : 1 - dependencies_.render.main_busy_share.value();
  return 1000 * std::max(left_share, kShare);
}

double ViewAdmission::taken_ms(const View* view, bool own_camera) const {
  return (own_camera ? kLeastCameraHz : kLeastLightHz) * cost_ms(view, own_camera);
}

Result<void> ViewAdmission::check_budget(const View* wanted, bool own_camera, std::int64_t now_ns) const {
  double others_ms = 0;
  for (const View& view : views_) {
    if (view.wanted.view_id != 0 && &view != wanted) others_ms += taken_ms(&view, view.wanted.own_camera);
  }
  const double left_ms = this->left_ms(now_ns);
  const double wanted_ms = taken_ms(wanted, own_camera);
  if (wanted_ms + others_ms <= left_ms) return {};
  return Error{
      ErrorCode::kUnavailable,
      fmt::format(
          "this machine is too busy for {} of your own: it would take {:.0f} % of the time, and "
          "{:.0f} % are free{}; expected {}",
          own_camera ? "a camera" : "a light", wanted_ms / 10, std::max(left_ms - others_ms, 0.0) / 10,
          others_ms > 0
              ? fmt::format(", since other displays with views of their own take {:.0f} %", others_ms / 10)
              : "",
          own_camera ? "the camera that all share (a light of your own takes less), a smaller "
                       "picture, or a faster machine"
                     : "fewer displays with views of their own, a smaller picture, or a faster "
                       "machine")};
}

Result<ViewAdmission::View*> ViewAdmission::open(std::uint64_t session) {
  const auto taken = static_cast<std::size_t>(
      std::ranges::count_if(views_, [](const View& each) { return each.wanted.view_id != 0; }));
  const auto free = std::ranges::find(views_, 0U, [](const View& each) { return each.wanted.view_id; });
  if (taken >= most_views_ || free == views_.end()) {
    return Error{
        ErrorCode::kUnavailable,
        fmt::format("{} displays already have a view of their own, expected a later request", taken)};
  }
  View& view = *free;
  if (view.pictures == nullptr)
    view.pictures = std::make_unique<Mailbox<Picture>>(
        dependencies_.link.to_server, blank_picture(picture_size_.width, picture_size_.height));
  view.wanted = {.view_id = session, .pictures = view.pictures.get()};
  view.own.clear();
  view.seconds_behind = 0;
  view.own_times = {};
  view.volume_shown = view.revision_shown = 0;
  return &view;
}

Result<void> ViewAdmission::change(std::uint64_t session, const v1::Scene& change, const SceneField** refused,
                                   std::int64_t now_ns) {
  thread_owner_.check();
  if (most_views_ == 0)
    return Error{ErrorCode::kUnavailable, "there are no private views here, expected the main view"};
  const auto groups = private_groups(change);
  if (!groups) return groups.error();
  View* view = find(session);
  const Scene& before =
      view != nullptr ? view->wanted.scene.scene : dependencies_.scene_store.in_force().scene;
  auto scene = changed_scene(before, change, refused);
  if (!scene) return scene.error();
  const bool own_camera = (view != nullptr && view->wanted.own_camera) || groups->contains("camera");
  if (auto fits = check_budget(view, own_camera, now_ns); !fits) return fits;
  if (view == nullptr) {
    const auto opened = open(session);
    if (!opened) return opened.error();
    view = *opened;
  }
  view->own.insert(groups->begin(), groups->end());
  view->wanted.own_camera = own_camera;
  view->wanted.scene = {.revision = ++revisions_, .scene = *scene};
  publish();
  return {};
}

bool ViewAdmission::leave(std::uint64_t session) {
  thread_owner_.check();
  View* const view = find(session);
  if (view == nullptr) return false;
  view->wanted.view_id = 0;
  publish();
  return true;
}

void ViewAdmission::publish() {
  PrivateViews& draft = dependencies_.link.private_views.draft();
  std::uint64_t open = 0;
  for (std::size_t index = 0; index < views_.size(); ++index) {
    draft[index] = views_[index].wanted;
    open += draft[index].view_id != 0 ? 1 : 0;
  }
  dependencies_.link.private_views.publish();
  dependencies_.counters.private_views.set(open);
}

v1::ViewState ViewAdmission::state(std::uint64_t session) const {
  v1::ViewState state;
  const View* const view = find(session);
  if (view == nullptr) return state;
  state.set_is_private(true);
  for (const std::string& group : view->own) state.add_own(group);
  state.set_revision(view->wanted.scene.revision);
  *state.mutable_scene() = scene_message(view->wanted.scene.scene);
  return state;
}

std::uint64_t ViewAdmission::revision(std::uint64_t session) const {
  const View* const view = find(session);
  return view == nullptr ? 0 : view->wanted.scene.revision;
}

std::vector<std::uint64_t> ViewAdmission::main_changed() {
  thread_owner_.check();
  std::vector<std::uint64_t> changed;
  for (View& view : views_) {
    if (view.wanted.view_id == 0) continue;
    const Scene& before = view.wanted.scene.scene;
    const Scene now = combined(dependencies_.scene_store.in_force().scene, before, view.own);
    if (first_pass_changed(before, now) == FirstPass::kNone) continue;
    view.wanted.scene = {.revision = ++revisions_, .scene = now};
    changed.push_back(view.wanted.view_id);
  }
  if (!changed.empty()) publish();
  return changed;
}

void ViewAdmission::main_shown(const PictureStamp& stamp, std::int64_t now_ns) {
  thread_owner_.check();
  main_shown_ns_ = now_ns;
  main_volume_ = stamp.volume.volume_id;
  main_times_.note(stamp.stage_ms);
}

std::vector<const Picture*> ViewAdmission::newest(std::int64_t now_ns) {
  thread_owner_.check();
  std::vector<const Picture*> pictures;
  has_more_ = false;
  for (View& view : views_) {
    if (view.pictures == nullptr) continue;
    if (now_ns - view.shown_ns < kBetweenPicturesNs) {
      has_more_ = true;  // possibly: a mailbox shows only by a read whether it has a picture
      continue;
    }
    const Picture* const picture = view.pictures->newest();
    if (picture == nullptr || picture->stamp.view_id != view.wanted.view_id) continue;
    view.shown_ns = now_ns;
    view.own_times.note(picture->stamp.stage_ms);
    view.volume_shown = picture->stamp.volume.volume_id;
    view.revision_shown = picture->stamp.scene_revision;
    view.seconds_behind = 0;
    pictures.push_back(picture);
  }
  return pictures;
}

bool ViewAdmission::over_budget(std::int64_t now_ns) const {
  if (main_at_rest(now_ns)) return false;
  // By what a picture costs now, which is more than at the admission where the main view's filters, or the
  // view's own, have become dearer.
  double all_ms = 0;
  for (const View& view : views_) {
    if (view.wanted.view_id != 0) all_ms += taken_ms(&view, view.wanted.own_camera);
  }
  return all_ms > left_ms(now_ns);
}

std::vector<ViewAdmission::EndedView> ViewAdmission::ended_by_renderer(const PrivateViewEnds& ends) {
  thread_owner_.check();
  std::vector<EndedView> ended;
  for (const PrivateViewEnd& end : ends) {
    const View* const view = find(end.view_id);
    // A later change of the view opens it again.
    if (view == nullptr || view->wanted.scene.revision > end.revision) continue;
    ended.push_back({.session = end.view_id, .reason = std::string(end.reason.view())});
  }
  for (const EndedView& view : ended) leave(view.session);
  return ended;
}

std::vector<ViewAdmission::EndedView> ViewAdmission::second_passed(std::int64_t now_ns) {
  thread_owner_.check();
  std::vector<EndedView> ended;
  for (View& view : views_) {
    if (view.wanted.view_id == 0 || main_shown_ns_ == 0) continue;
    const bool behind =
        view.volume_shown != main_volume_ || view.revision_shown != view.wanted.scene.revision;
    view.seconds_behind = behind ? view.seconds_behind + 1 : 0;
    if (view.seconds_behind >= kMostSecondsBehind)
      ended.push_back({.session = view.wanted.view_id, .reason = "this machine had no time for it for 5 s"});
  }
  seconds_over_budget_ = ended.empty() && over_budget(now_ns) ? seconds_over_budget_ + 1 : 0;
  if (seconds_over_budget_ >= kMostSecondsBehind) {
    seconds_over_budget_ = 0;
    const auto dearest = std::ranges::max_element(views_, {}, [this](const View& view) {
      return view.wanted.view_id == 0 ? -1 : cost_ms(&view, view.wanted.own_camera);
    });
    ended.push_back(
        {.session = dearest->wanted.view_id,
         .reason = fmt::format("this machine has become too busy for it: a picture takes {:.0f} ms",
                               cost_ms(&*dearest, dearest->wanted.own_camera))});
  }
  for (const EndedView& view : ended) leave(view.session);
  return ended;
}

}  // namespace fanlight
