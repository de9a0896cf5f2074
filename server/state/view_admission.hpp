// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "proto/base/counter.hpp"
#include "proto/base/thread_owner.hpp"
#include "proto/exchange/render_link.hpp"
#include "proto/fanlight.pb.h"
#include "server/state/scene_store.hpp"
#include "server/state/server_counters.hpp"

namespace fanlight {

/// Admits private views: decides whether a session may have one, and keeps its scene. A view has some groups
/// of scene fields of its own (camera, light, ...); all other groups follow the scene in force. Pure logic:
/// time is a parameter. Server thread only.
///
/// The budget: at one picture in two seconds each, or one in four with a camera of its own, all views must
/// fit into the time that the main view leaves, or into the share that is theirs in any case (kMainTimes).
/// The cost of a pass is its time in the main view or in the view itself, whichever is longer; the time left
/// follows from the busy share of the main view in the last second. A view that is behind for five seconds
/// ends.
class ViewAdmission {
 public:
  /// All must outlive this object.
  struct Dependencies {
    RenderLink& link;
    const SceneStore& scene_store;
    const RenderCounters& render;
    ServerCounters& counters;
  };
  ViewAdmission(const Dependencies& dependencies, std::size_t most_views, PictureSize usual)
      : dependencies_(dependencies), most_views_(most_views), picture_size_(usual) {}

  /// Least time between two pictures of a view: fluent for a person, and a bounded load for the encoders.
  static constexpr std::int64_t kBetweenPicturesNs = 33'000'000;

  /// Changes fields of the view of a session, and makes their groups its own; opens the view if there is
  /// none. On an error nothing changes: kInvalidArgument for a field that cannot be private or a value out of
  /// range (`refused`: as in changed_scene()), kUnavailable beyond the budget.
  Result<void> change(std::uint64_t session, const v1::Scene& change, const SceneField** refused,
                      std::int64_t now_ns);

  /// Ends the view of the session; false if there is none.
  bool leave(std::uint64_t session);

  bool has(std::uint64_t session) const { return find(session) != nullptr; }
  v1::ViewState state(std::uint64_t session) const;
  /// Revision of the scene of its view; 0 without a view.
  std::uint64_t revision(std::uint64_t session) const;

  /// The scene in force has changed. Returns the sessions whose views change with it.
  std::vector<std::uint64_t> main_changed();

  /// A picture of the main view was shown. Its stage times give the cost of a pass.
  void main_shown(const PictureStamp& stamp, std::int64_t now_ns);

  /// The new pictures of private views, valid until the next call. Skips views that have ended, and views
  /// whose last picture is younger than kBetweenPicturesNs: then has_more() is true, and the caller should
  /// call again after that time.
  std::vector<const Picture*> newest(std::int64_t now_ns);
  bool has_more() const { return has_more_; }

  /// A view that the server has ended, and why, as a sentence.
  struct EndedView {
    std::uint64_t session = 0;
    std::string reason;
  };
  /// Called once a second. Ends the views that were behind for too long, and the dearest one where all
  /// together have cost more than the main view leaves for too long: a scene may get dearer after it was
  /// admitted.
  std::vector<EndedView> second_passed(std::int64_t now_ns);

  /// The renderer has ended views. Removes them. Returns the messages for their sessions.
  std::vector<EndedView> ended_by_renderer(const PrivateViewEnds& ends);

 private:
  /// What each stage of a view took in the last picture that ran it; 0 before its second run. The first one
  /// is not counted: the driver compiles in it, which may take ten times as long.
  struct StageTimes {
    std::array<double, kStages> ms{};
    std::array<bool, kStages> has_run{};
    void note(const std::array<double, kStages>& stage_ms);
  };
  struct View {
    PrivateView wanted;                          // view_id: the session; 0: the slot is free
    std::set<std::string, std::less<>> own;      // groups of fields that do not follow the scene in force
    std::unique_ptr<Mailbox<Picture>> pictures;  // kept when the slot becomes free
    StageTimes own_times;                        // of its own pictures
    std::int64_t shown_ns = 0;
    std::uint64_t volume_shown = 0;
    std::uint64_t revision_shown = 0;
    int seconds_behind = 0;
  };
  bool main_at_rest(std::int64_t now_ns) const;
  /// Time of each second that private views may take.
  double left_ms(std::int64_t now_ns) const;
  /// Time of each second that the view takes. `view` null: a new one.
  double taken_ms(const View* view, bool own_camera) const;
  bool over_budget(std::int64_t now_ns) const;
  View* find(std::uint64_t session);
  const View* find(std::uint64_t session) const { return const_cast<ViewAdmission*>(this)->find(session); }
  Result<View*> open(std::uint64_t session);
  /// `wanted`: the view that changes, or null for a new one.
  Result<void> check_budget(const View* wanted, bool own_camera, std::int64_t now_ns) const;
  /// Time of one picture of the view. `view` null: a new one.
  double cost_ms(const View* view, bool own_camera) const;
  void publish();

  Dependencies dependencies_;
  std::size_t most_views_;
  PictureSize picture_size_;
  std::array<View, kMostPrivateViews> views_;
  StageTimes main_times_;
  std::int64_t main_shown_ns_ = 0;
  bool has_more_ = false;
  int seconds_over_budget_ = 0;
  std::uint64_t main_volume_ = 0;
  std::uint64_t revisions_ = 0;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
