// SPDX-License-Identifier: Apache-2.0
#include "tests/hot_path/pipeline_fixture.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "proto/base/clock.hpp"
#include "renderer/cast_means.hpp"

namespace fanlight::test {

namespace {

constexpr PictureSize kSize{.width = 96, .height = 96};
constexpr std::int64_t kLongestNs = 30'000'000'000;

/// Ids of the threads of this process.
std::vector<pid_t> threads() {
  std::vector<pid_t> ids;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    ids.push_back(std::stoi(entry.path().filename()));
  }
  return ids;
}

/// The ids of the threads that start() starts.
template <typename Start>
std::vector<pid_t> threads_started_by(Start start) {
  const std::vector<pid_t> before = threads();
  start();
  std::vector<pid_t> started = threads();
  std::erase_if(started, [&](pid_t id) { return std::ranges::find(before, id) != before.end(); });
  return started;
}

Scene scene_of(const SourceDescription& source) {
  return scene_for(source.geometry, source.first_angle_rad, source.last_angle_rad, kSize.height);
}

}  // namespace

PipelineFixture::PipelineFixture(FrameSource& source, RingPolicy policy,
                                 const std::filesystem::path& recordings)
    : suggested_(scene_of(source.description())) {
  auto pipeline = Pipeline::create(
      {.size = kSize, .scene = suggested_, .policy = policy, .recordings = {.folder = recordings}},
      {.open_device = [](const std::string& name) { return open_device(name, live_device_options()); },
       .source = source,
       .link = link_});
  if (!pipeline) throw std::runtime_error(pipeline.error().message);
  pipeline_ = std::move(*pipeline);
  ports_.emplace(pipeline_->ports());
  if (const auto recorder = ports_->recording) {
    recorder->send(
        {.number = 1, .wish = RecordingOrder::Wish::kRecord, .path = recordings / "frames.igs.mha"});
    while (recording().state != RecordingStatus::State::kRecording) link_.server_bell.wait(kLongestNs);
  }
  started_ns_ = now_ns();
  thread_ids_ = threads_started_by([this] { pipeline_->start(); });
  if (thread_ids_.size() != 2) throw std::runtime_error("another thread was started at the same time");
}

RecordingStatus PipelineFixture::recording() {
  const RecordingStatus* newest = ports_->recording->status.newest();
  if (newest != nullptr) recording_ = *newest;
  return recording_;
}

std::uint64_t PipelineFixture::show(const Scene& scene) {
  ports_->render.scenes.draft() = {.revision = ++revision_, .scene = scene};
  ports_->render.scenes.publish();
  return revision_;
}

const Picture& PipelineFixture::next_picture() {
  const std::int64_t deadline_ns = now_ns() + kLongestNs;
  for (;;) {
    while (const auto answer = ports_->render.answers.take()) {
      if (const auto* failure = std::get_if<Error>(&*answer)) throw std::runtime_error(failure->message);
    }
    if (const std::string state = pipeline_->source_state(); state != "running") {
      throw std::runtime_error("the source is no longer running: " + state);
    }
    if (const Picture* picture = ports_->render.pictures.newest()) return *picture;
    const std::int64_t left_ns = deadline_ns - now_ns();
    if (left_ns <= 0) throw std::runtime_error("no picture came within half a minute");
    link_.server_bell.wait(left_ns);
  }
}

void PipelineFixture::make_hot() {
  for (const pid_t id : thread_ids_) hot_threads_.push_back(std::make_unique<HotThread>(id));
}

}  // namespace fanlight::test
