// SPDX-License-Identifier: Apache-2.0
// The render thread with its ring and mailboxes; the test plays the acquisition thread and the server thread.
#include "renderer/render_thread.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "proto/base/clock.hpp"
#include "tests/support/gpu_rig.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test::render_thread_tests {
namespace {

constexpr const FanGeometry& kGeometry = kSmallFan;
constexpr FanGeometry kDeeper{.columns = 48,
                              .rows = 70,
                              .pixel_width_mm = 2,
                              .pixel_height_mm = 2,
                              .face_column = 23.5,
                              .face_row = 0,
                              .motor_radius_mm = 30};
constexpr PictureSize kSize{.width = 64, .height = 64};
constexpr PictureSize kLargest{.width = 150, .height = 150};

class RenderThreadTest : public GpuTest {
 protected:
  void SetUp() override {
    // A test can exceed the limits of a texture without using much memory.
    auto renderer = made_renderer(kGeometry, angles_rad_, kSize, scene_, counters_,
                                  {.sampling = Sampling::kTexture, .largest_size = kLargest});
    thread_ = std::make_unique<RenderThread>(
        DeviceRenderer{.renderer = std::move(renderer)},
        RenderThread::Dependencies{.ring = ring_, .link = link_, .counters = counters_});
  }

  /// A volume of a plate at this depth, with that geometry.
  Volume plate(double depth_mm, const FanGeometry& geometry = kGeometry) const {
    return made_volume(geometry, angles_rad_, [=](const Point& at) { return at.y_mm > depth_mm ? 150 : 5; });
  }
  /// Publishes a copy in the ring.
  void publish(const Volume& copied) {
    Volume* volume = ring_.begin();
    volume->set_geometry(copied.geometry());
    for (std::uint32_t frame = 0; frame < angles_rad_.size(); ++frame) {
      std::ranges::copy(copied.frame_pixels(frame), volume->next_frame_pixels().begin());
      volume->add_frame(
          {.sequence = frame, .angle_rad = angles_rad_[frame], .capture_time_ns = captured_ns_ += 1'000'000});
    }
    volume->sort_by_angle();
    ring_.publish();
  }

  const Picture& next_picture() {
    for (;;) {
      if (const Picture* picture = pictures_.newest()) return *picture;
      server_bell_.wait(-1);
    }
  }

  VolumeAnswer ordered_volume(std::uint64_t number, const std::shared_ptr<Volume>& into) {
    link_.send(VolumeOrder{.number = number, .into = into});
    for (;;) {
      if (const auto answer = newest<VolumeAnswer>()) return *answer;
      server_bell_.wait(-1);
    }
  }
  void send(const CineOrder& order) { link_.send(order); }

  /// The newest answer of this kind since the last call; drops all others.
  template <typename Answer>
  std::optional<Answer> newest() {
    std::optional<Answer> found;
    while (const auto answer = link_.answers.take()) {
      if (const auto* each = std::get_if<Answer>(&*answer)) found = *each;
    }
    return found;
  }

  void request(std::uint64_t revision, const Scene& scene) {
    scenes_.draft() = {.revision = revision, .scene = scene};
    scenes_.publish();
  }
  /// Waits for the next picture of that scene.
  const Picture& next_picture_of(std::uint64_t revision) {
    for (;;) {
      const Picture& picture = next_picture();
      if (picture.stamp.scene_revision == revision) return picture;
    }
  }

  /// A geometry beyond the GPU's limits.
  static FanGeometry too_wide() {
    FanGeometry geometry = kGeometry;
    geometry.columns = gpu().limits().maxImageDimension3D + 1;
    geometry.rows = 2;
    return geometry;
  }

  std::uint64_t volumes_accounted_for() const {
    return counters_.volumes_rendered.value() + counters_.volumes_skipped.value() +
           counters_.volumes_refused.value() + counters_.volumes_unwatched.value();
  }
  /// Waits until the ring is empty and no volume is in flight; 30 s at most.
  void rest() const {
    const RingCounters& ring = ring_.counters();
    const std::int64_t deadline_ns = now_ns() + 30'000'000'000;
    while (now_ns() < deadline_ns) {
      const std::uint64_t taken = ring.volumes_taken.value();
      if (taken == volumes_accounted_for() &&
          taken + ring.volumes_dropped.value() == ring.volumes_published.value()) {
        return;
      }
      std::this_thread::yield();
    }
  }

  const std::vector<double> angles_rad_ = {-0.4, -0.3, -0.2, -0.1, 0, 0.1, 0.2, 0.3, 0.4};
  const Scene scene_ = scene_for(kGeometry, angles_rad_.front(), angles_rad_.back());
  Doorbell render_bell_;
  Doorbell server_bell_;
  Doorbell writer_bell_;
  VolumeRing ring_{{.geometry = kGeometry,
                    .frame_capacity = 9,
                    .kept = 3,
                    .largest_frame_bytes = std::max(kDeeper.frame_bytes(), too_wide().frame_bytes())},
                   {.reader_bell = render_bell_, .writer_bell = writer_bell_}};
  RenderLink link_{render_bell_, server_bell_};
  Mailbox<NumberedScene>& scenes_ = link_.scenes;
  Mailbox<Picture>& pictures_ = link_.pictures;
  Audience& audience_ = link_.audience;
  RenderCounters counters_;
  std::int64_t captured_ns_ = 0;
  std::unique_ptr<RenderThread> thread_;  // last: it uses the others
};

TEST_F(RenderThreadTest, AFrozenPictureGetsAsLargeAsADisplayShowsIt) {
  publish(plate(40));
  EXPECT_EQ(next_picture().width, kSize.width);
  send({.wish = CineOrder::Wish::kFreeze});
  link_.wanted_sizes.draft() = {.of_surfaces = PictureSize{400, 300}, .of_pictures = {}};
  link_.wanted_sizes.publish();
  while (next_picture().width == kSize.width) {
  }
  link_.wanted_sizes.draft() = {};
  link_.wanted_sizes.publish();
  while (next_picture().width != kSize.width) {
  }
}

TEST_F(RenderThreadTest, ObeysAnOrderBehindAVolumeOrder) {
  using State = CineStatus::State;
  publish(plate(60));
  next_picture();
  rest();
  for (const State wanted : {State::kFrozen, State::kLive, State::kFrozen}) {
    // At rest; a thread that is still busy looks for orders anyway.
    while (counters_.turn_began_ns.value() != 0) std::this_thread::yield();
    // With one ring for both, as where the thread was busy when they came: it must not rest after the first.
    ASSERT_TRUE(link_.orders.put(VolumeOrder{.number = 1, .into = nullptr}));
    ASSERT_TRUE(link_.orders.put(
        CineOrder{.wish = wanted == State::kFrozen ? CineOrder::Wish::kFreeze : CineOrder::Wish::kLive}));
    render_bell_.ring();
    bool volume_answered = false;
    bool obeyed = false;
    for (int i = 0; i < 500 && !(volume_answered && obeyed); ++i) {
      server_bell_.wait(10'000'000);
      while (const auto answer = link_.answers.take()) {
        volume_answered |= std::holds_alternative<VolumeAnswer>(*answer);
        const auto* const status = std::get_if<CineStatus>(&*answer);
        obeyed |= status != nullptr && status->state == wanted;
      }
    }
    ASSERT_TRUE(volume_answered);
    ASSERT_TRUE(obeyed) << "frozen or live: " << static_cast<int>(wanted);
  }
}

TEST_F(RenderThreadTest, RendersNothingWithoutViewersAndTheNewestVolumeForTheNextOne) {
  audience_.set_present(false);
  for (int volume = 1; volume <= 3; ++volume) {
    publish(plate(40));
    rest();
  }
  EXPECT_EQ(counters_.volumes_unwatched.value() + ring_.counters().volumes_dropped.value(), 3U);
  EXPECT_EQ(counters_.pass1_runs.value(), 0U);
  EXPECT_EQ(pictures_.newest(), nullptr);
  audience_.set_present(true);
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 3U);
  publish(plate(41));
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 4U);
  rest();
  EXPECT_EQ(volumes_accounted_for(), ring_.counters().volumes_taken.value());
}

TEST_F(RenderThreadTest, ShowsTheLastVolumeAgainAfterARestWithoutANewOne) {
  publish(plate(40));
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 1U);
  rest();
  audience_.set_present(false);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  audience_.set_present(true);
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 1U) << "the server has forgotten the picture of before";
  rest();
  EXPECT_EQ(volumes_accounted_for(), 1U) << "it is counted once";

  send({.wish = CineOrder::Wish::kFreeze});
  audience_.set_present(false);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(pictures_.newest(), nullptr);
  audience_.set_present(true);
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 1U) << "a frozen one too";
}

TEST_F(RenderThreadTest, MakesAPictureOfAVolumeAndAnotherOfAMovedLight) {
  publish(plate(40));
  const Picture first = next_picture();
  EXPECT_EQ(first.stamp.volume.volume_id, 1U);
  EXPECT_EQ(first.width, kSize.width);
  EXPECT_EQ(first.rgba.size(), std::size_t{4} * kSize.width * kSize.height);
  EXPECT_GT(first.stamp.stage_ms[static_cast<std::size_t>(Stage::kCast)], 0);

  NumberedScene moved{.revision = 2, .scene = scene_};
  moved.scene.light.right_mm = 60;
  scenes_.draft() = moved;
  scenes_.publish();
  const Picture second = next_picture();
  EXPECT_EQ(second.stamp.scene_revision, 2U);
  EXPECT_EQ(second.stamp.volume.volume_id, 1U);
  EXPECT_EQ(second.stamp.pass1_runs, first.stamp.pass1_runs);
  EXPECT_NE(second.rgba, first.rgba);
}

TEST_F(RenderThreadTest, ShowsTheLastVolumesAgainWhileFrozen) {
  using Wish = CineOrder::Wish;
  std::vector<Picture> live;
  for (int volume = 0; volume < 6; ++volume) {
    publish(plate(35 + 3 * volume));
    live.push_back(next_picture());
  }
  const std::uint64_t rendered = counters_.volumes_rendered.value();
  send({.wish = Wish::kFreeze});
  send({.wish = Wish::kStep, .volumes = -2});
  const Picture older = next_picture();
  EXPECT_EQ(older.stamp.volume.volume_id, 4U);
  EXPECT_EQ(older.rgba, live[3].rgba);
  const auto told = newest<CineStatus>();
  ASSERT_TRUE(told);
  EXPECT_EQ(*told, (CineStatus{.state = CineStatus::State::kFrozen,
                               .capacity = 3,
                               .volumes = 4,
                               .volume = 1,
                               .time_s = 0.009,
                               .duration_s = 0.027,
                               .volume_id = 4}));

  publish(plate(60));  // comes to no picture now
  Scene moved = scene_;
  moved.light.right_mm = 60;
  request(2, moved);
  const Picture lit = next_picture_of(2);
  EXPECT_EQ(lit.stamp.volume.volume_id, 4U) << "the light moves on a frozen volume";
  EXPECT_EQ(lit.stamp.pass1_runs, older.stamp.pass1_runs);
  moved.camera.yaw_deg = 20;
  request(3, moved);
  EXPECT_EQ(next_picture_of(3).stamp.volume.volume_id, 4U) << "so does the camera";
  EXPECT_EQ(counters_.volumes_rendered.value(), rendered) << "no volume is counted twice";

  send({.wish = Wish::kLive});
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 7U);
}

TEST_F(RenderThreadTest, CopiesTheVolumeOnShow) {
  using Outcome = VolumeAnswer::Outcome;
  EXPECT_EQ(ordered_volume(1, nullptr).outcome, Outcome::kNoVolume);
  const Volume first = plate(40);
  publish(first);
  (void)next_picture();
  const VolumeAnswer small = ordered_volume(2, std::make_shared<Volume>(kGeometry, 2));
  EXPECT_EQ(small.outcome, Outcome::kTooSmall);
  EXPECT_EQ(small.number, 2U);
  const auto copy = std::make_shared<Volume>(small.geometry, small.frames);
  ASSERT_EQ(ordered_volume(3, copy).outcome, Outcome::kCopied);
  EXPECT_EQ(copy->stamp().volume_id, 1U);
  EXPECT_TRUE(std::ranges::equal(copy->frame_pixels(4), first.frame_pixels(4)));
  EXPECT_TRUE(std::ranges::equal(copy->by_angle(), first.by_angle()));

  publish(plate(50));
  (void)next_picture();
  send({.wish = CineOrder::Wish::kFreeze});
  send({.wish = CineOrder::Wish::kStep, .volumes = -1});
  (void)next_picture();
  ASSERT_EQ(ordered_volume(4, copy).outcome, Outcome::kCopied);
  EXPECT_EQ(copy->stamp().volume_id, 1U) << "the one that the frozen display shows";
}

TEST_F(RenderThreadTest, ReturnsToTheNewestVolumeWhereNoOtherComes) {
  for (int volume = 0; volume < 3; ++volume) {
    publish(plate(35 + 3 * volume));
    next_picture();
  }
  send({.wish = CineOrder::Wish::kFreeze});
  send({.wish = CineOrder::Wish::kSeek, .volume = 0});
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 1U);
  send({.wish = CineOrder::Wish::kLive});
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 3U);
}

TEST_F(RenderThreadTest, FreezesTheVolumeThatTheUserSees) {
  for (int volume = 0; volume < 3; ++volume) {
    publish(plate(35 + 3 * volume));
    next_picture();
  }
  send({.wish = CineOrder::Wish::kFreeze, .volume_id = 2});
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 2U);
  send({.wish = CineOrder::Wish::kLive});
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 3U);
  send({.wish = CineOrder::Wish::kFreeze, .volume_id = 99});
  send({.wish = CineOrder::Wish::kStep, .volumes = -1});
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 2U) << "of a volume that is not kept: the newest";
}

TEST_F(RenderThreadTest, FreezesTheFirstVolumeWhereThereWasNone) {
  send({.wish = CineOrder::Wish::kFreeze});
  publish(plate(40));
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 1U);
  publish(plate(45));
  Scene moved = scene_;
  moved.camera.yaw_deg = 10;
  request(2, moved);
  EXPECT_EQ(next_picture_of(2).stamp.volume.volume_id, 1U);
}

TEST_F(RenderThreadTest, ShowsTheNewestAgainWhereFrozenBeforeItCameBack) {
  for (int volume = 0; volume < 3; ++volume) {
    publish(plate(35 + 3 * volume));
    next_picture();
  }
  using Wish = CineOrder::Wish;
  send({.wish = Wish::kFreeze});
  send({.wish = Wish::kSeek, .volume = 0});
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 1U);
  send({.wish = Wish::kLive});
  send({.wish = Wish::kFreeze});
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 3U);
}

TEST_F(RenderThreadTest, PlaysTheLastVolumesInALoop) {
  for (int volume = 0; volume < 3; ++volume) {
    publish(plate(35 + 3 * volume));
    next_picture();
  }
  send({.wish = CineOrder::Wish::kSpeed, .speed = 0.1});
  send({.wish = CineOrder::Wish::kFreeze});
  send({.wish = CineOrder::Wish::kPlay});
  std::vector<std::uint64_t> shown;
  while (shown.size() < 4) shown.push_back(next_picture().stamp.volume.volume_id);
  EXPECT_EQ(shown, (std::vector<std::uint64_t>{1, 2, 3, 1}));
}

TEST_F(RenderThreadTest, EndsUpAtTheNewestVolumeAndScene) {
  constexpr std::uint64_t kVolumes = 30;
  for (std::uint64_t volume = 1; volume <= kVolumes; ++volume) {
    publish(plate(30 + static_cast<double>(volume)));
    scenes_.draft() = {.revision = volume + 1, .scene = scene_};
    scenes_.draft().scene.camera.yaw_deg = static_cast<double>(volume);
    scenes_.publish();
  }
  std::uint64_t shown = 0;
  while (true) {
    const PictureStamp stamp = next_picture().stamp;
    EXPECT_GE(stamp.volume.volume_id, shown) << "an older volume came after a newer one";
    shown = stamp.volume.volume_id;
    if (shown == kVolumes && stamp.scene_revision == kVolumes + 1) break;
  }
  thread_.reset();
  EXPECT_EQ(ring_.counters().volumes_published.value(), kVolumes);
  EXPECT_EQ(ring_.counters().volumes_taken.value() + ring_.counters().volumes_dropped.value(), kVolumes);
  EXPECT_FALSE(newest<Error>());
}

TEST_F(RenderThreadTest, AccountsForEveryVolumeThatItTook) {
  const RingCounters& ring = ring_.counters();
  const Volume volumes[] = {plate(45), plate(45, kDeeper), plate(45), plate(45, too_wide())};
  // Several volumes at once, of changing geometry, while the camera turns.
  constexpr std::uint64_t kRounds = 24;
  for (std::uint64_t round = 0; round < kRounds; ++round) {
    const std::uint64_t taken_before = ring.volumes_taken.value();
    for (std::uint64_t volume = 0; volume < 3; ++volume) publish(volumes[(round + volume) % 4]);
    while (ring.volumes_taken.value() == taken_before) {
      const std::uint64_t accounted_for = volumes_accounted_for();
      ASSERT_LE(accounted_for, ring.volumes_taken.value());
    }
    scenes_.draft() = {.revision = round + 2, .scene = scene_};
    scenes_.draft().scene.rays.step_mm = 0.05;  // several bands, between which a cast is given up
    scenes_.draft().scene.camera.yaw_deg = 0.5 * static_cast<double>(round);
    scenes_.publish();
  }
  rest();
  EXPECT_EQ(ring.volumes_taken.value() + ring.volumes_dropped.value(), 3 * kRounds);
  EXPECT_EQ(volumes_accounted_for(), ring.volumes_taken.value());
  EXPECT_GE(ring.volumes_taken.value(), kRounds);
  EXPECT_GT(counters_.volumes_rendered.value(), 0U);
  EXPECT_GT(counters_.volumes_refused.value(), 0U);
  EXPECT_LE(counters_.volumes_rendered.value(), counters_.pictures_finished.value());
  EXPECT_FALSE(newest<Error>());
}

TEST_F(RenderThreadTest, GoesOnAfterAVolumeThatTheGpuCannotHave) {
  publish(plate(45, too_wide()));
  rest();
  EXPECT_EQ(counters_.volumes_refused.value(), 1U);
  publish(plate(45));
  EXPECT_EQ(next_picture().stamp.volume.volume_id, 2U);
  EXPECT_FALSE(newest<Error>());
}

TEST_F(RenderThreadTest, TakesFromThePicturesWhatTheirRateNeedsAndGivesItBack) {
  // Every sample of a ray counts, some 5000. For a fast GPU the window of rays grows step by step.
  Scene heavy = scene_;
  heavy.mode = Mode::kMean;
  heavy.rays.step_mm = 0.02;
  heavy.finish.smoothing = Smoothing::kNone;
  heavy.deadline = {.plan = DeadlinePlan::kHoldRate, .rate_hz = 60};
  const Volume volume = plate(45);
  std::uint64_t revision = 2;
  request(revision, heavy);
  publish(volume);
  Picture full = next_picture_of(revision);
  EXPECT_EQ(full.stamp.deadline_level, 0);
  EXPECT_EQ(full.stamp.measures, DeadlineMeasures{});
  Picture coarse = full;
  const auto held = [](const PictureStamp& stamp) {
    return stamp.measures.coarse && stamp.deadline_level >= 2;
  };
  for (int volumes = 0; volumes < 60 && !held(coarse.stamp); ++volumes) {
    if (volumes > 0 && volumes % 15 == 0) {
      heavy.rays.window += 2;
      request(++revision, heavy);
      do full = next_picture_of(revision);
      while (full.stamp.measures != DeadlineMeasures{});
    }
    publish(volume);
    coarse = next_picture_of(revision);
  }
  EXPECT_GE(coarse.stamp.deadline_level, 2);
  ASSERT_TRUE(coarse.stamp.measures.coarse);
  EXPECT_NE(coarse.rgba, full.rgba);
  const auto row = [&](std::uint32_t number) {
    return std::span(coarse.rgba)
        .subspan(std::size_t{4} * kSize.width * number, std::size_t{4} * kSize.width);
  };
  for (std::uint32_t number = 0; number < kSize.height; number += 2) {
    EXPECT_TRUE(std::ranges::equal(row(number), row(number + 1))) << number;
  }

  // No more volumes arrive: a picture of full quality follows, with the same revision.
  Picture still = coarse;
  while (still.stamp.measures != DeadlineMeasures{}) still = next_picture();
  EXPECT_EQ(still.stamp.scene_revision, revision);
  EXPECT_GE(still.stamp.deadline_level, 2);
  EXPECT_EQ(still.rgba, full.rgba);

  // A moved view is coarse again, but not without the plan.
  heavy.camera.yaw_deg = 1;
  request(++revision, heavy);
  EXPECT_TRUE(next_picture_of(revision).stamp.measures.coarse);
  heavy.camera.yaw_deg = 0;
  heavy.deadline.plan = DeadlinePlan::kOff;
  request(++revision, heavy);
  const Picture& off = next_picture_of(revision);
  EXPECT_EQ(off.stamp.deadline_level, 0);
  EXPECT_EQ(off.stamp.measures, DeadlineMeasures{});
  EXPECT_EQ(off.rgba, full.rgba);
  EXPECT_FALSE(newest<Error>());
}

TEST_F(RenderThreadTest, EndsInTheMiddleOfItsWork) {
  publish(plate(40));
  publish(plate(41));
  thread_.reset();  // returns, also with work in flight
  EXPECT_EQ(volumes_accounted_for(), ring_.counters().volumes_taken.value());
}

}  // namespace
}  // namespace fanlight::test::render_thread_tests
