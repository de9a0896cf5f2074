// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pthread.h>

#include <cmath>
#include <ctime>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "proto/base/clock.hpp"
#include "server/service/stream_server.hpp"

namespace fanlight::test {

/// A server on a free loopback port in its own thread. The test takes the place of the renderer and the
/// acquisition: it shows pictures and reads scenes. Test thread only.
class ServerFixture {
 public:
  static constexpr std::uint32_t kWidth = 64;
  static constexpr std::uint32_t kHeight = 48;
  static constexpr PictureSize kNoiseSize{.width = 640, .height = 480};    ///< of show_noise()
  static constexpr PictureSize kSurfaceSize{.width = 512, .height = 512};  ///< of show_surface()

  explicit ServerFixture(std::size_t most_connections = 64, std::string source_state = "running",
                         ProbeControl probe_control = ProbeControl::kEveryone)
      : ServerFixture(StreamServer::Config{.state = {.probe_control = probe_control},
                                           .most_connections = most_connections},
                      std::move(source_state)) {}

  /// Uses the access options and limits of `config`; sets the endpoint, the description but for its path, and
  /// the scene itself.
  /// `usual`: the size of the server's pictures.
  explicit ServerFixture(StreamServer::Config config, std::string source_state = "running",
                         PictureSize usual = {.width = kWidth, .height = kHeight},
                         const OpenStillArchive& open_archive = {})
      : source_state_(std::move(source_state)) {
    config.endpoint = {boost::asio::ip::make_address("127.0.0.1"), 0};
    config.state.description = {
        .source = "fake:", .path = config.state.description.path, .device = "none", .picture_size = usual};
    config.state.initial_scene = {.revision = 1, .scene = {}};
    std::optional<RecordingLink> recording;
    if (!config.state.recording.folder.empty())
      recording.emplace(RecordingLink{recording_orders_, scene_bell_, recording_status_, picture_notes_});
    auto server = StreamServer::create(
        config, {.ports = {.render = link_,
                           .probe = probe_,
                           .replay = replay_,
                           .counters = {acquisition_, ring_, feed_, render_, probe_.counters, probe_.igtl},
                           .source_state = [this] { return source_state_; },
                           .recording = recording},
                 .counters = counters_,
                 .find_surface = [this](const Volume&, const Scene& scene,
                                        const std::stop_token&) { return find_surface(scene); },
                 .measure_fluid = [](const Volume&, const FluidQuestion& question,
                                     const std::stop_token&) { return made_region(question); },
                 .open_archive = open_archive});
    if (!server) throw std::runtime_error(server.error().message);
    server_ = std::move(*server);
    endpoint_ = server_->endpoint();
    thread_ = std::jthread([this] { result_ = server_->run(); });
  }
  ~ServerFixture() {
    server_->stop();
    if (thread_.joinable()) thread_.join();
  }

  boost::asio::ip::tcp::endpoint endpoint() const { return endpoint_; }
  /// Of OpenIGTLink, where the configuration has it.
  std::uint16_t igtl_port() const { return server_->igtl_endpoint()->port(); }
  const ServerCounters& counters() const { return counters_; }

  void report_replay(const ReplayStatus& status) {
    replay_.status.draft() = status;
    replay_.status.publish();
  }
  /// Waits for the next order to the player of a recording.
  void report_cine(const CineStatus& status) { link_.answer(status); }
  /// As the render thread: the next order; waits up to 5 s.
  template <typename Order>
  Order next_order() {
    for (int i = 0; i < 500; ++i) {
      if (auto order = link_.orders.take()) return std::get<Order>(*std::move(order));
      scene_bell_.wait(10'000'000);
    }
    throw std::runtime_error("no order for the render thread has come");
  }
  CineOrder next_cine_order() { return next_order<CineOrder>(); }
  ReplayOrder next_replay_order() {
    for (int i = 0; i < 2000; ++i) {
      if (const auto order = replay_.orders.take()) return *order;
      replay_.player_bell.wait(5'000'000);
    }
    throw std::runtime_error("no order for the replay has come");
  }

  /// Shows a picture of kWidth x kHeight with one grey level.
  void show(std::uint64_t picture_id, std::uint8_t grey) { show({.picture_id = picture_id}, grey); }
  void show(const PictureStamp& stamp, std::uint8_t grey) {
    show(stamp, kWidth, kHeight, [grey](std::size_t /*value*/) { return grey; });
  }

  /// Shows a picture of noise, which no codec compresses: about half a megabyte as JPEG.
  void show_noise(std::uint64_t picture_id) {
    std::uint32_t state = static_cast<std::uint32_t>(picture_id);
    show({.picture_id = picture_id}, kNoiseSize.width, kNoiseSize.height, [&state](std::size_t /*value*/) {
      state = 1'664'525 * state + 1'013'904'223;  // linear congruential generator of Numerical Recipes
      return static_cast<std::uint8_t>(state >> 24);
    });
  }

  /// Shows a picture with the depths `depth_at(column, row)` in mm. The view direction is y; a pixel is 0.5
  /// mm, and pixel (5, 6) is at the origin.
  template <typename DepthAt>
  void show_depths(std::uint64_t picture_id, DepthAt depth_at) {
    std::vector<float>& depth_mm = pictures_.draft().depth_mm;
    depth_mm.clear();
    pictures_.draft().certainty.assign(std::size_t{kWidth} * kHeight, 255);
    for (std::uint32_t row = 0; row < kHeight; ++row) {
      for (std::uint32_t column = 0; column < kWidth; ++column) depth_mm.push_back(depth_at(column, row));
    }
    show({.picture_id = picture_id,
          .view = {.right = {1, 0, 0},
                   .down = {0, 0, -1},
                   .forward = {0, 1, 0},
                   .mm_per_pixel = 0.5,
                   .middle_column = 5,
                   .middle_row = 6,
                   .part = {.width = kWidth, .height = kHeight}}},
         128);
  }

  /// Shows a shaded dome of 512 x 512 pixels with a grain that differs between pictures. A codec needs about
  /// as many bytes for it as for a rendered surface.
  void show_surface(std::uint64_t picture_id) {
    constexpr std::uint32_t kSide = kSurfaceSize.width;
    show({.picture_id = picture_id}, kSide, kSide, [picture_id](std::size_t at) {
      const double x = (static_cast<double>(at / 4 % kSide) - 256) / 200;
      const double y = (static_cast<double>(at / 4 / kSide) - 256) / 200;
      const double height = 1 - x * x - y * y;
      if (height <= 0) return std::uint8_t{0};
      const double grain = 12 * std::sin(40 * x + 0.3 * static_cast<double>(picture_id)) * std::sin(40 * y);
      return static_cast<std::uint8_t>(40 + 180 * std::sqrt(height) + grain);
    });
  }

  /// Processor time of the server thread so far, in seconds; 0 if it is unknown.
  double server_processor_s() {
    clockid_t clock{};
    timespec time{};
    if (pthread_getcpuclockid(thread_.native_handle(), &clock) != 0 || clock_gettime(clock, &time) != 0)
      return 0;
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) / 1e9;
  }

  /// Blocks until the server publishes a scene, and returns the newest.
  NumberedScene next_scene() {
    for (;;) {
      if (const NumberedScene* scene = scenes_.newest()) return *scene;
      scene_bell_.wait(-1);
    }
  }
  bool has_scene() { return scenes_.newest() != nullptr; }

  /// Blocks until the server publishes private views, and returns the newest.
  PrivateViews next_private_views() {
    for (;;) {
      if (const PrivateViews* views = private_views_.newest()) return *views;
      scene_bell_.wait(-1);
    }
  }
  /// Shows a picture of one grey level in a private view.
  void show_in(const PrivateView& view, const PictureStamp& stamp, std::uint8_t grey) {
    show(*view.pictures, stamp, kWidth, kHeight, [grey](std::size_t /*value*/) { return grey; });
  }
  /// Busy share of the main view, as the render thread reports it.
  void set_main_busy_share(double share) { render_.main_busy_share.set(share); }

  /// As the render thread: when it began the turn that it is in.
  void set_turn_began_ns(std::int64_t time_ns) { render_.turn_began_ns.set(time_ns); }

  /// As the render thread: waits up to 5 s for the next order for the volume that is shown, and answers it.
  void answer_volume_order(const Volume* shown) { link_.answer(answer_to(next_order<VolumeOrder>(), shown)); }
  bool has_volume_order() { return link_.orders.take().has_value(); }
  /// As the render thread and the finder of surfaces: answers the next survey. `find`: called on another
  /// thread.
  void answer_survey(std::function<std::optional<FoundSurface>(const Scene& scene)> find) {
    const Volume volume(FanGeometry{.columns = 2, .rows = 2}, 1);
    {
      const std::lock_guard lock(find_mutex_);
      find_ = std::move(find);
    }
    VolumeAnswer::Outcome outcome{};
    do {
      VolumeAnswer answer = answer_to(next_order<VolumeOrder>(), &volume);
      outcome = answer.outcome;
      link_.answer(std::move(answer));
    } while (outcome == VolumeAnswer::Outcome::kTooSmall);
  }

  /// As the render thread: answers the next orders for the volume that is shown until it is copied. The meter
  /// of fluid then finds a region whose volume is the question's x, or none where that is negative.
  void answer_fluid(std::uint64_t shown_volume_id) {
    Volume volume(FanGeometry{.columns = 2, .rows = 2}, 1);
    volume.stamp().volume_id = shown_volume_id;
    VolumeAnswer::Outcome outcome{};
    do {
      VolumeAnswer answer = answer_to(next_order<VolumeOrder>(), &volume);
      outcome = answer.outcome;
      link_.answer(std::move(answer));
    } while (outcome == VolumeAnswer::Outcome::kTooSmall);
  }

  /// Blocks until the server has an order for the recorder, and returns it.
  RecordingOrder next_recording_order() {
    for (;;) {
      if (auto order = recording_orders_.take()) return *std::move(order);
      scene_bell_.wait(-1);
    }
  }
  /// As the recorder.
  void report_recording(const RecordingStatus& status) {
    recording_status_.draft() = status;
    recording_status_.publish();
  }

  /// The probe link, for use as the acquisition thread.
  ProbeLink& probe() { return probe_; }

  /// Reports a failure of the renderer, which ends the server.
  void fail(const Error& error) { link_.answer(error); }
  /// Blocks until run() of the server has returned, and returns its result.
  Result<void> wait_for_end() {
    thread_.join();
    return result_;
  }

 private:
  static Result<v1::FluidRegion> made_region(const FluidQuestion& question) {
    if (question.at.x_mm < 0) return Error{ErrorCode::kInvalidArgument, "this point is not in fluid"};
    v1::FluidRegion region;
    region.set_volume_mm3(question.at.x_mm);
    region.set_step_mm(0.5);
    region.set_columns(2);
    region.set_rows(3);
    region.set_slices(4);
    region.set_depths(std::string(24, '\x90'));
    return region;
  }
  std::optional<FoundSurface> find_surface(const Scene& scene) {
    const std::lock_guard lock(find_mutex_);
    return find_ ? find_(scene) : std::nullopt;
  }
  template <typename Value>
  void show(PictureStamp stamp, std::uint32_t width, std::uint32_t height, Value value) {
    stamp.scene_revision = 1;
    if (stamp.volume.last_capture_time_ns == 0) stamp.volume.last_capture_time_ns = now_ns();
    show(pictures_, stamp, width, height, value);
  }
  template <typename Value>
  static void show(Mailbox<Picture>& pictures, const PictureStamp& stamp, std::uint32_t width,
                   std::uint32_t height, Value value) {
    Picture& picture = pictures.draft();
    picture.stamp = stamp;
    picture.width = width;
    picture.height = height;
    picture.rgba.resize(std::size_t{4} * width * height);
    for (std::size_t at = 0; at < picture.rgba.size(); ++at) picture.rgba[at] = value(at);
    picture.stamp.finished_time_ns = now_ns();
    pictures.publish();
  }

  const std::string source_state_;
  Doorbell bell_;
  Doorbell scene_bell_;
  RenderLink link_{scene_bell_, bell_};
  Mailbox<Picture>& pictures_ = link_.pictures;
  Mailbox<NumberedScene>& scenes_ = link_.scenes;
  Mailbox<PrivateViews>& private_views_ = link_.private_views;
  std::mutex find_mutex_;
  std::function<std::optional<FoundSurface>(const Scene&)> find_;
  RecordingOrders recording_orders_;
  Mailbox<RecordingStatus> recording_status_{bell_};
  LineQueue picture_notes_;
  AcquisitionCounters acquisition_;
  RingCounters ring_;
  QueueCounters feed_;
  RenderCounters render_;
  Doorbell acquisition_bell_;
  ProbeLink probe_{acquisition_bell_, bell_};
  ReplayLink replay_{bell_};
  ServerCounters counters_;
  std::unique_ptr<StreamServer> server_;
  boost::asio::ip::tcp::endpoint endpoint_;
  Result<void> result_;
  std::jthread thread_;
};

}  // namespace fanlight::test
