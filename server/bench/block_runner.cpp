// SPDX-License-Identifier: Apache-2.0
#include "server/bench/block_runner.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "proto/base/clock.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/mailbox.hpp"
#include "renderer/schedule/main_schedule.hpp"

namespace fanlight {

namespace {

constexpr std::int64_t kMostWaitNs = 2'000'000;       // for the GPU; that of the render thread
constexpr std::chrono::microseconds kFramePoll{500};  // while there is no work

/// Encodes the newest picture on its own thread.
class EncodingThread {
 public:
  EncodingThread() : pictures_(bell_), thread_([this](const std::stop_token& stop) { run(stop); }) {}
  ~EncodingThread() {
    thread_.request_stop();
    bell_.ring();
  }

  Mailbox<Picture>& pictures() { return pictures_; }

  /// Ends the thread when the last published picture is encoded.
  Result<std::vector<EncodingTrace>> finish() {
    thread_.request_stop();
    bell_.ring();
    thread_.join();
    if (failure_) return *failure_;
    return std::move(done_);
  }

 private:
  void run(const std::stop_token& stop) {
    for (;;) {
      const bool last = stop.stop_requested();  // before the last look for a picture
      const Picture* const picture = pictures_.newest();
      if (picture == nullptr) {
        if (last) return;
        bell_.wait(-1);
        continue;
      }
      const std::int64_t from_ns = now_ns();
      if (const auto jpeg = encoder_.encode(pixels_of(*picture), true); !jpeg) {
        failure_ = jpeg.error();
        return;
      }
      done_.push_back(
          {.volume_id = picture->stamp.volume.volume_id, .span = {.begin_ns = from_ns, .end_ns = now_ns()}});
    }
  }

  Doorbell bell_;
  Mailbox<Picture> pictures_;
  JpegCoder encoder_{kBenchJpegQuality};
  std::vector<EncodingTrace> done_;  // like failure_, the thread's until it has ended
  std::optional<Error> failure_;
  std::jthread thread_;  // last: it uses the other members
};

}  // namespace

Result<BlockTrace> BlockRunner::serial(int volumes) {
  BlockTrace block;
  for (int volume = 0; volume < volumes; ++volume) {
    if (auto loaded = load(block, volumes_.next()); !loaded) return loaded.error();
    if (auto rendered = render_and_collect(); !rendered) return rendered.error();
    record_stages(block, picture_);
    const std::int64_t from_ns = now_ns();
    if (auto jpeg = encoder_.encode(pixels_of(picture_), true); !jpeg) return jpeg.error();
    block.encodings.push_back(
        {.volume_id = picture_.stamp.volume.volume_id, .span = {.begin_ns = from_ns, .end_ns = now_ns()}});
  }
  return block;
}

Result<void> BlockRunner::render_and_collect() {
  for (;;) {
    if (auto advanced = renderer_.advance(); !advanced) return advanced;
    if (renderer_.collect(picture_)) return {};
    if (auto waited = renderer_.wait(kMostWaitNs); !waited) return waited.error();
  }
}

Result<BlockTrace> BlockRunner::pipelined(int volumes) {
  BlockTrace block;
  EncodingThread encoder;
  int to_load = volumes;
  for (int to_collect = volumes; to_collect > 0;) {
    if (to_load > 0 && renderer_.wants_volume()) {
      if (auto loaded = load(block, volumes_.next()); !loaded) return loaded.error();
      --to_load;
    }
    if (auto advanced = renderer_.advance(); !advanced) return advanced.error();
    if (collect(block, encoder.pictures())) {
      --to_collect;
      continue;  // its slot is free now
    }
    if (to_load > 0 && renderer_.wants_volume()) continue;  // advance() has made room
    if (auto waited = renderer_.wait(kMostWaitNs); !waited) return waited.error();
  }
  auto encodings = encoder.finish();
  if (!encodings) return encodings.error();
  block.encodings = std::move(*encodings);
  return block;
}

Result<BlockTrace> BlockRunner::live(int volumes, std::int64_t sweep_ns, Arrival arrival) {
  BlockTrace block;
  EncodingThread encoder;
  LiveFeed feed(volumes_, sweep_ns, arrival);
  int to_load = volumes;
  for (int to_collect = volumes; to_collect > 0;) {
    feed.advance();
    if (to_load > 0 && feed.complete() != nullptr && renderer_.wants_volume()) {
      if (auto loaded = load(block, *feed.complete()); !loaded) return loaded.error();
      block.volumes.back().complete_ns = feed.completed_ns();
      feed.take_complete();
      --to_load;
    }
    take_frames(feed);
    const auto next = to_load > 0 && feed.complete() != nullptr ? Renderer::NextVolume::kWaits
                                                                : Renderer::NextVolume::kUnknown;
    if (auto advanced = renderer_.advance(Renderer::NewWork::kBegins, next); !advanced)
      return advanced.error();
    if (collect(block, encoder.pictures())) {
      --to_collect;
      continue;
    }
    if (to_load > 0 && feed.complete() != nullptr && renderer_.wants_volume()) continue;
    if (!renderer_.busy()) std::this_thread::sleep_for(kFramePoll);
    if (auto waited = renderer_.wait(kMostWaitNs); !waited) return waited.error();
  }
  auto encodings = encoder.finish();
  if (!encodings) return encodings.error();
  block.encodings = std::move(*encodings);
  return block;
}

/// As RenderThread::take_frames().
void BlockRunner::take_frames(LiveFeed& feed) {
  while (renderer_.wants_frame()) {
    const QueuedFrame* const frame = feed.frames().front();
    if (frame == nullptr) return;
    if (stays_queued(frame->stamp.commit_number, feed.waiting_commit_number(), false)) return;
    renderer_.take_frame(*frame);
    feed.frames().pop();
  }
}

bool BlockRunner::collect(BlockTrace& block, Mailbox<Picture>& pictures) {
  if (!renderer_.collect(pictures.draft())) return false;
  record_stages(block, pictures.draft());
  pictures.publish();
  return true;
}

Result<void> BlockRunner::load(BlockTrace& block, const Volume& volume) {
  const std::int64_t from_ns = now_ns();
  if (auto loaded = renderer_.load(volume); !loaded) return loaded;
  block.volumes.push_back({.volume_id = volume.stamp().volume_id,
                           .load = {.begin_ns = from_ns, .end_ns = now_ns()},
                           .stages = {}});
  return {};
}

void BlockRunner::record_stages(BlockTrace& block, const Picture& picture) const {
  const auto volume =
      std::ranges::find(block.volumes, picture.stamp.volume.volume_id, &VolumeTrace::volume_id);
  if (volume == block.volumes.end()) return;
  volume->stages = renderer_.stage_spans();
  volume->finished_ns = picture.stamp.finished_time_ns;
}

}  // namespace fanlight
