// SPDX-License-Identifier: Apache-2.0
#include "server/pipeline/pipeline.hpp"

#include <algorithm>
#include <utility>

#include "acquisition/source/frame_source.hpp"
#include "renderer/renderer.hpp"

namespace fanlight {

namespace {

VolumeRing::Config ring_config(const SourceDescription& source, const Pipeline::Config& config) {
  return {.geometry = source.geometry,
          .frame_capacity = source.frames_per_volume,
          .slots = config.ring_slots,
          .kept = config.cine_volumes,
          .policy = config.policy,
          .largest_frame_bytes = source.largest_frame_bytes};
}

/// While a volume waits for the end of a cast, the frames of the volume after it wait in the queue: for most
/// of a sweep where volumes come faster than casts.
FrameQueue::Config queue_config(const SourceDescription& source) {
  constexpr std::uint64_t kQueueBytes = 16'000'000;
  const std::uint64_t largest_frame_bytes =
      std::max<std::uint64_t>(source.geometry.frame_bytes(), source.largest_frame_bytes);
  return {.largest_frame_bytes = largest_frame_bytes,
          .slots = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
              kQueueBytes / std::max<std::uint64_t>(largest_frame_bytes, 1), 8, 64))};
}

Renderer::Config renderer_config(const SourceDescription& source, const Pipeline::Config& config) {
  return {.size = config.size,
          .largest_size = config.largest_size,
          .geometry = source.geometry,
          .first_angle_rad = source.first_angle_rad,
          .last_angle_rad = source.last_angle_rad,
          .frame_capacity = source.frames_per_volume,
          .usual_frames = source.usual_frames,
          .pipeline_cache = config.pipeline_cache,
          .watchdog = config.watchdog};
}

}  // namespace

Pipeline::Pipeline(const Config& config, const Dependencies& dependencies)
    : open_device_(dependencies.open_device),
      gpu_wanted_(config.gpu),
      renderer_config_(renderer_config(dependencies.source.description(), config)),
      source_(dependencies.source),
      link_(dependencies.link),
      mismatch_(config.mismatch),
      ring_(ring_config(source_.description(), config),
            {.reader_bell = render_bell_, .writer_bell = link_.acquisition_bell}),
      queue_(queue_config(source_.description()), {.reader_bell = render_bell_}),
      render_link_(render_bell_, link_.server_bell, blank_picture(config.size.width, config.size.height),
                   config.largest_size) {
  if (!config.recordings.folder.empty())
    recorder_.emplace(source_.description(), link_.server_bell, config.recordings);
  // A third of a second at 100 MB/s: the server does not wait for a disk.
  constexpr std::uint64_t kSentBytes = 32'000'000;
  if (config.sends_frames)
    sent_frames_.emplace(queue_config(source_.description()).largest_frame_bytes, link_.server_bell,
                         kSentBytes);
}

Result<std::unique_ptr<Pipeline>> Pipeline::create(const Config& config, const Dependencies& dependencies) {
  std::unique_ptr<Pipeline> made(new Pipeline(config, dependencies));
  // A source that waits, or that ends, would lose its first frames.
  const bool is_live = !dependencies.source.waits() && dependencies.source.description().volumes == 0;
  if (config.acquires_early && is_live) made->start_acquisition();
  if (auto opened = made->open(config); !opened) return opened.error();
  return made;
}

Result<void> Pipeline::open(const Config& config) {
  auto device = open_device_(gpu_wanted_);
  if (!device) return device.error();
  gpus_ = device->instance->candidates();
  gpu_ = device->gpu->candidate();
  auto renderer = make_renderer(std::move(*device), {.revision = 1, .scene = config.scene});
  if (!renderer) return renderer.error();
  renderer_ = std::move(*renderer);
  return {};
}

Result<DeviceRenderer> Pipeline::make_renderer(RenderDevice device, const NumberedScene& scene) {
  const Renderer::Dependencies dependencies{
      .gpu = *device.gpu, .counters = render_counters_, .light_gpu = device.light_gpu.get()};
  auto renderer = Renderer::create(renderer_config_, dependencies, scene);
  if (!renderer && renderer.error().code == ErrorCode::kUnavailable && renderer_config_.largest_size) {
    // Finer pictures are no reason not to render at all.
    Renderer::Config smaller = renderer_config_;
    smaller.largest_size.reset();
    renderer = Renderer::create(smaller, dependencies, scene);
  }
  if (!renderer) return renderer.error();
  return DeviceRenderer{.device = std::move(device), .renderer = std::move(*renderer)};
}

Result<DeviceRenderer> Pipeline::remake(const NumberedScene& scene) {
  auto device = open_device_(gpu_.name);
  // It may not come back after its loss.
  if (!device && device.error().code == ErrorCode::kNotFound) device = open_device_(gpu_wanted_);
  if (!device) return device.error();
  return make_renderer(std::move(*device), scene);
}

PipelinePorts Pipeline::ports() {
  return {.render = render_link_,
          .probe = link_.probe,
          .replay = link_.replay,
          .counters = counters(),
          .source_state = [this] { return source_state(); },
          .recording = recorder_ ? std::optional(recorder_->link()) : std::nullopt,
          .frames = sent_frames_ ? &*sent_frames_ : nullptr};
}

void Pipeline::start() {
  render_thread_.emplace(
      std::move(renderer_),
      RenderThread::Dependencies{.ring = ring_,
                                 .link = render_link_,
                                 .counters = render_counters_,
                                 .feed = &queue_,
                                 .remake = [this](const NumberedScene& scene) { return remake(scene); }});
  if (!acquisition_thread_) start_acquisition();
}

void Pipeline::start_acquisition() {
  acquisition_thread_.emplace(
      AcquisitionThread::Dependencies{
          .source = source_,
          .ring = ring_,
          .writer_bell = link_.acquisition_bell,
          .counters = acquisition_counters_,
          .ended_bell = link_.server_bell,
          .frame_queue = &queue_,
          .taps = {recorder_ ? &recorder_->tap() : nullptr, sent_frames_ ? &*sent_frames_ : nullptr},
          .pulse = &acquisition_pulse_},
      mismatch_);
}

bool Pipeline::stop() {
  acquisition_thread_.reset();
  if (recorder_) recorder_->end(Recorder::Finish::kLeave);
  if (!render_thread_) return true;
  const bool ended = render_thread_->end(kMostStopNs);
  if (ended) render_thread_.reset();
  return ended;
}

std::string Pipeline::source_state() const {
  if (!acquisition_thread_) return "ended";
  switch (acquisition_thread_->state()) {
    case AcquisitionThread::State::kRunning:
      return "running";
    case AcquisitionThread::State::kFailed:
      return acquisition_thread_->error().message;
    default:
      return "ended";
  }
}

}  // namespace fanlight
