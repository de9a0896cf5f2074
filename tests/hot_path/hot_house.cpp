#include "tests/hot_path/hot_house.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/clock.hpp"
#include "tests/hot_path/plain_gpu.hpp"

namespace fanlight::test {

namespace {

constexpr PictureSize kSize{.width = 96, .height = 96};
constexpr std::int64_t kLongestNs = 30'000'000'000;

/// Ids of this process's threads.
std::vector<pid_t> threads() {
  std::vector<pid_t> ids;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    ids.push_back(std::stoi(entry.path().filename()));
  }
  return ids;
}

/// The id of the one thread that start() starts.
template <typename Start>
pid_t thread_started_by(Start start) {
  const std::vector<pid_t> before = threads();
  start();
  std::vector<pid_t> started = threads();
  std::erase_if(started, [&](pid_t id) { return std::ranges::find(before, id) != before.end(); });
  if (started.size() != 1) throw std::runtime_error("another thread was started at the same time");
  return started.front();
}

Scene scene_of(const SourceDescription& source) {
  return scene_for(source.geometry, source.first_angle_rad, source.last_angle_rad, kSize.height);
}

std::unique_ptr<Renderer> renderer_for(const SourceDescription& source, const Scene& scene,
                                       RenderCounters& counters) {
  auto made = Renderer::create({.size = kSize,
                                .geometry = source.geometry,
                                .first_angle_rad = source.first_angle_rad,
                                .last_angle_rad = source.last_angle_rad,
                                .frame_capacity = source.frames_per_volume,
                                .usual_frames = source.usual_frames},
                               {.gpu = plain_gpu(), .counters = counters}, {.revision = 1, .scene = scene});
  if (!made) throw std::runtime_error(made.error().message);
  return std::move(*made);
}

}  // namespace

Picture HotHouse::blank_picture() {
  return fanlight::blank_picture(kSize.width, kSize.height);
}

HotHouse::HotHouse(FrameSource& source, RingPolicy policy, const Picture& blank)
    : suggested_(scene_of(source.description())),
      ring_({.geometry = source.description().geometry,
             .frame_capacity = source.description().frames_per_volume,
             .policy = policy,
             .largest_frame_bytes = source.description().largest_frame_bytes},
            {.reader_bell = render_bell_, .writer_bell = acquisition_bell_}),
      pictures_(server_bell_, blank) {
  auto renderer = renderer_for(source.description(), suggested_, render_counters_);
  started_ns_ = now_ns();
  render_id_ = thread_started_by([&] {
    render_ = std::make_unique<RenderThread>(std::move(renderer),
                                             RenderThread::Dependencies{.ring = ring_,
                                                                        .scenes = scenes_,
                                                                        .pictures = pictures_,
                                                                        .counters = render_counters_,
                                                                        .bell = render_bell_,
                                                                        .failures = failures_});
  });
  acquisition_id_ = thread_started_by([&] {
    acquisition_ =
        std::make_unique<AcquisitionThread>(AcquisitionThread::Dependencies{.source = source,
                                                                            .ring = ring_,
                                                                            .writer_bell = acquisition_bell_,
                                                                            .counters = acquisition_counters_,
                                                                            .ended_bell = server_bell_});
  });
}

HotHouse::~HotHouse() = default;

std::uint64_t HotHouse::show(const Scene& scene) {
  scenes_.draft() = {.revision = ++revision_, .scene = scene};
  scenes_.publish();
  return revision_;
}

const Picture& HotHouse::next_picture() {
  const std::int64_t deadline_ns = now_ns() + kLongestNs;
  for (;;) {
    if (const Error* failure = failures_.newest()) throw std::runtime_error(failure->message);
    if (acquisition_->state() != AcquisitionThread::State::kRunning) {
      throw std::runtime_error("the source has ended");
    }
    if (const Picture* picture = pictures_.newest()) return *picture;
    const std::int64_t left_ns = deadline_ns - now_ns();
    if (left_ns <= 0) throw std::runtime_error("no picture came within half a minute");
    server_bell_.wait(left_ns);
  }
}

void HotHouse::make_hot() {
  hot_acquisition_.emplace(acquisition_id_);
  hot_render_.emplace(render_id_);
}

}  // namespace fanlight::test
