// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "proto/base/clock.hpp"
#include "renderer/render_thread.hpp"
#include "tests/gpu/gpu_faults.hpp"
#include "tests/support/made_volume.hpp"

namespace fanlight::test {

/// The render thread with devices of its own, which it makes again after a fault; validation layers on. The
/// test plays the acquisition thread and the server thread. Nothing waits longer than two minutes.
class FaultyPipeline : public testing::Test {
 protected:
  static constexpr FanGeometry kGeometry = kSmallFan;
  static constexpr FanGeometry kDeeper{.columns = 48,
                                       .rows = 70,
                                       .pixel_width_mm = 2,
                                       .pixel_height_mm = 2,
                                       .face_column = 23.5,
                                       .face_row = 0,
                                       .motor_radius_mm = 30};
  static constexpr PictureSize kSize{.width = 64, .height = 64};
  static constexpr std::int64_t kLongestNs = 120'000'000'000;

  void TearDown() override {
    clear_gpu_faults();
    EXPECT_TRUE(eventually([this] { return thread_ == nullptr || thread_->end(kLongestNs); }));
    thread_.reset();
    EXPECT_TRUE(wait_for_gpu_instances(instances_before_)) << "a device stays";
    EXPECT_EQ(messages_.value(), 0U) << "the validation layers reported messages, see above";
  }

  /// The limits of the watchdog for a test that is to see a hang; others keep those of production.
  static Watchdog::Limits impatient() {
    return {.least_slow_ns = 500'000'000, .least_hung_ns = 3'000'000'000, .most_hung_ns = 3'000'000'000};
  }

  void start(const std::optional<Watchdog::Limits>& limits = {}) {
    limits_ = limits;
    instances_before_ = gpu_instances();
    auto made = make({.revision = 1, .scene = scene_});
    ASSERT_TRUE(made) << made.error().message;
    thread_ = std::make_unique<RenderThread>(
        std::move(*made),
        RenderThread::Dependencies{.ring = ring_,
                                   .link = link_,
                                   .counters = counters_,
                                   .remake = [this](const NumberedScene& scene) { return remake(scene); }});
  }

  /// Makes another device once the last one is destroyed. The validation layers of Debian 12 look devices up
  /// without a lock, and crash where another thread creates one (KhronosGroup/Vulkan-ValidationLayers, issue
  /// 4391). A device that hangs is not destroyed before the end of the test.
  Result<DeviceRenderer> remake(const NumberedScene& scene) {
    const bool is_gone = limits_ || wait_for_gpu_instances(instances_before_);
    EXPECT_TRUE(is_gone) << "the last device stays";
    return make(scene);
  }

  Result<DeviceRenderer> make(const NumberedScene& scene) {
    auto device =
        open_device("", {.instance = {.validation = true, .messages = &messages_}, .own_light_device = true});
    if (!device) return device.error();
    auto renderer = Renderer::create(
        {.size = kSize,
         .geometry = kGeometry,
         .first_angle_rad = angles_rad_.front(),
         .last_angle_rad = angles_rad_.back(),
         .frame_capacity = 9,
         .sampling = sampling_,
         .watchdog = limits_},
        {.gpu = *device->gpu, .counters = counters_, .light_gpu = device->light_gpu.get()}, scene);
    if (!renderer) return renderer.error();
    return DeviceRenderer{.device = std::move(*device), .renderer = std::move(*renderer)};
  }

  /// Publishes a volume of a plate at this depth; returns its number.
  std::uint64_t publish(double depth_mm, const FanGeometry& geometry = kGeometry) {
    const Volume copied =
        made_volume(geometry, angles_rad_, [=](const Point& at) { return at.y_mm > depth_mm ? 150 : 5; });
    Volume* volume = ring_.begin();
    volume->set_geometry(geometry);
    for (std::uint32_t frame = 0; frame < angles_rad_.size(); ++frame) {
      std::ranges::copy(copied.frame_pixels(frame), volume->next_frame_pixels().begin());
      volume->add_frame({.sequence = frame, .angle_rad = angles_rad_[frame]});
    }
    volume->sort_by_angle();
    ring_.publish();
    return ++volumes_;
  }

  void show(std::uint64_t revision, const Scene& scene) {
    scenes_.draft() = {.revision = revision, .scene = scene};
    scenes_.publish();
  }

  /// Calls `happened` again with each ring of the bell, and once in a while. Whether it came true in time.
  template <typename Happened>
  bool eventually(Happened happened) {
    const std::int64_t deadline_ns = now_ns() + kLongestNs;
    while (!happened()) {
      if (now_ns() > deadline_ns) return false;
      server_bell_.wait(20'000'000);
    }
    return true;
  }

  /// The next picture of that volume or a later one; none in time: an empty one. Checks the order of the
  /// pictures, and reads the other mailboxes meanwhile.
  Picture picture_of(std::uint64_t volume_id) {
    Picture found;
    EXPECT_TRUE(eventually([&] {
      read_others();
      const Picture* const newest = pictures_.newest();
      if (newest == nullptr) return false;
      EXPECT_GT(newest->stamp.picture_id, last_picture_id_);
      last_picture_id_ = newest->stamp.picture_id;
      found = *newest;
      return newest->stamp.volume.volume_id >= volume_id;
    })) << "no picture of volume "
        << volume_id << "; failure: " << (failure_ ? failure_->message : "none");
    return found;
  }

  /// Reads health, failures and ends of private views.
  void read_others() {
    while (const auto answer = link_.answers.take()) {
      if (const auto* failure = std::get_if<Error>(&*answer)) failure_ = *failure;
      if (const auto* ends = std::get_if<PrivateViewEnds>(&*answer)) ends_ = *ends;
      if (const auto* health = std::get_if<RenderHealth>(&*answer)) seen_.push_back(*health);
    }
  }
  bool saw(RenderHealth::State state) const {
    return std::ranges::any_of(seen_, [state](const RenderHealth& each) { return each.state == state; });
  }

  void expect_sums() const {
    EXPECT_EQ(ring_.counters().volumes_taken.value(), counters_.volumes_rendered.value() +
                                                          counters_.volumes_skipped.value() +
                                                          counters_.volumes_refused.value());
    EXPECT_EQ(counters_.pass2_runs.value(), counters_.pictures_finished.value() +
                                                counters_.pictures_outdated.value() +
                                                counters_.pictures_lost.value());
  }

  const std::vector<double> angles_rad_ = {-0.4, -0.3, -0.2, -0.1, 0, 0.1, 0.2, 0.3, 0.4};
  const Scene scene_ = scene_for(kGeometry, angles_rad_.front(), angles_rad_.back());
  std::optional<Watchdog::Limits> limits_;
  std::optional<Sampling> sampling_;  // of start(); absent: as usual
  int instances_before_ = 0;          // start()
  Counter messages_;
  Doorbell render_bell_;
  Doorbell server_bell_;
  Doorbell writer_bell_;
  VolumeRing ring_{{.geometry = kGeometry, .frame_capacity = 9, .largest_frame_bytes = kDeeper.frame_bytes()},
                   {.reader_bell = render_bell_, .writer_bell = writer_bell_}};
  RenderLink link_{render_bell_, server_bell_};
  Mailbox<NumberedScene>& scenes_ = link_.scenes;
  Mailbox<PrivateViews>& private_views_ = link_.private_views;
  Mailbox<Picture>& pictures_ = link_.pictures;
  Mailbox<Picture> private_pictures_{server_bell_};
  RenderCounters counters_;
  std::uint64_t volumes_ = 0;
  std::uint64_t last_picture_id_ = 0;
  std::optional<Error> failure_;
  PrivateViewEnds ends_;
  std::vector<RenderHealth> seen_;
  std::unique_ptr<RenderThread> thread_;  // last: it uses the others
};

}  // namespace fanlight::test
