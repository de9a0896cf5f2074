#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "proto/counter.hpp"
#include "proto/doorbell.hpp"
#include "proto/fanlight.pb.h"
#include "proto/private_view.hpp"
#include "server/scene_desk.hpp"
#include "server/server_counters.hpp"

namespace fanlight {

/// The private views: which session has one, what of its scene is its own, and whether there is time for it.
/// What is its own it has group by group (camera, light, ...); all else follows the scene in force. Server
/// thread only.
///
/// The budget: all views must come to two pictures a second in the time that the main view leaves, and a
/// camera to one cast between two volumes, by what passes took in the main view or, where that is more, in
/// the view itself, and by how busy the main view was in the last second. The renderer then draws them in
/// such time alone, and a view that for five seconds had none of it ends.
class ViewDesk {
 public:
  /// All must outlive the desk. `views` null: there are none to be had. `bell` is the server's.
  struct Dependencies {
    Mailbox<PrivateViews>* views = nullptr;
    Doorbell& bell;
    const SceneDesk& desk;
    const RenderCounters& render;
    ServerCounters& counters;
  };
  ViewDesk(const Dependencies& dependencies, std::size_t most_views, std::uint32_t width,
           std::uint32_t height)
      : from_(dependencies), most_views_(most_views), width_(width), height_(height) {}

  /// Between two pictures of a view: what a person sees, and no more than the encoders bear.
  static constexpr std::int64_t kBetweenPicturesNs = 33'000'000;

  /// Makes these fields, and the groups they are of, the session's own; opens its view where it has none.
  /// Errors, and nothing is done: kInvalidArgument for a field or a value that cannot be (`refused`: as in
  /// changed_scene()), kUnavailable beyond the budget.
  Result<void> change(std::uint64_t session, const v1::Scene& change, const SceneField** refused);

  /// Ends the session's view, where it has one.
  bool leave(std::uint64_t session);

  bool has(std::uint64_t session) const { return find(session) != nullptr; }
  v1::ViewState state(std::uint64_t session) const;
  /// Of its scene; 0 without a view.
  std::uint64_t revision(std::uint64_t session) const;

  /// The scene in force is another one: the sessions whose views are others now.
  std::vector<std::uint64_t> main_changed();

  /// A picture of the main view, whose stages tell what one costs.
  void main_shown(const PictureStamp& stamp);

  /// Private pictures that have come, until the next call. None of a view that has ended, nor of one that has
  /// just had one: then has_more(), and the caller should ask again in a while.
  std::vector<const Picture*> newest(std::int64_t now_ns);
  bool has_more() const { return has_more_; }

  /// The sessions whose views had no time for too long; their views have ended.
  std::vector<std::uint64_t> second_passed();

 private:
  struct View {
    PrivateView wanted;  // view_id: the session; 0: nobody's
    std::set<std::string, std::less<>> own;
    std::unique_ptr<Mailbox<Picture>> pictures;  // kept for the next one
    std::array<double, kStages> stage_ms{};      // of its own pictures, where it had any
    std::int64_t shown_ns = 0;
    std::uint64_t volume_shown = 0;
    std::uint64_t revision_shown = 0;
    int seconds_behind = 0;
  };
  View* find(std::uint64_t session);
  const View* find(std::uint64_t session) const { return const_cast<ViewDesk*>(this)->find(session); }
  Result<void> check_budget(const View* wanted, bool own_camera) const;
  double cost_ms(const View* view, bool own_camera) const;
  void publish();

  Dependencies from_;
  std::size_t most_views_;
  std::uint32_t width_;
  std::uint32_t height_;
  std::array<View, kMostPrivateViews> views_;
  std::array<double, kStages> stage_ms_{};  // each of the main view's last one
  std::int64_t main_shown_ns_ = 0;
  std::int64_t main_volume_ns_ = 0;
  double main_period_ms_ = 0;  // between the volumes that it showed
  bool has_more_ = false;
  std::uint64_t main_volume_ = 0;
  std::uint64_t revisions_ = 0;
};

}  // namespace fanlight
