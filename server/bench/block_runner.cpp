// SPDX-License-Identifier: Apache-2.0
#include "server/bench/block_runner.hpp"

#include <algorithm>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "proto/base/clock.hpp"
#include "proto/exchange/doorbell.hpp"
#include "proto/exchange/mailbox.hpp"

namespace fanlight {

namespace {

constexpr std::int64_t kMostWaitNs = 2'000'000;  // for the GPU; that of the render thread

/// Encodes the newest picture on its own thread, which ends after the picture of the last volume.
class EncodingThread {
 public:
  explicit EncodingThread(std::uint64_t last_volume_id)
      : pictures_(bell_),
        thread_([this, last_volume_id](const std::stop_token& stop) { run(stop, last_volume_id); }) {}
  ~EncodingThread() {
    thread_.request_stop();
    bell_.ring();
  }

  Mailbox<Picture>& pictures() { return pictures_; }

  /// Waits until the last picture is encoded, which must have been published.
  Result<std::vector<EncodingTrace>> join() {
    thread_.join();
    if (failure_) return *failure_;
    return std::move(done_);
  }

 private:
  void run(const std::stop_token& stop, std::uint64_t last_volume_id) {
    while (!stop.stop_requested()) {
      const Picture* const picture = pictures_.newest();
      if (picture == nullptr) {
        bell_.wait(-1);
        continue;
      }
      const std::int64_t from_ns = now_ns();
      if (const auto jpeg = encoder_.encode(pixels_of(*picture), true); !jpeg) {
        failure_ = jpeg.error();
        return;
      }
      const std::uint64_t volume_id = picture->stamp.volume.volume_id;
      done_.push_back({.volume_id = volume_id, .span = {.begin_ns = from_ns, .end_ns = now_ns()}});
      if (volume_id == last_volume_id) return;
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
    if (auto loaded = load(block); !loaded) return loaded.error();
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
  EncodingThread encoder(loaded_ + static_cast<std::uint64_t>(volumes));
  int to_load = volumes;
  for (int to_collect = volumes; to_collect > 0;) {
    if (to_load > 0 && renderer_.wants_volume()) {
      if (auto loaded = load(block); !loaded) return loaded.error();
      --to_load;
    }
    if (auto advanced = renderer_.advance(); !advanced) return advanced.error();
    if (renderer_.collect(encoder.pictures().draft())) {
      record_stages(block, encoder.pictures().draft());
      encoder.pictures().publish();
      --to_collect;
      continue;  // its slot is free now
    }
    if (to_load > 0 && renderer_.wants_volume()) continue;  // advance() has made room
    if (auto waited = renderer_.wait(kMostWaitNs); !waited) return waited.error();
  }
  auto encodings = encoder.join();
  if (!encodings) return encodings.error();
  block.encodings = std::move(*encodings);
  return block;
}

Result<void> BlockRunner::load(BlockTrace& block) {
  const Volume& volume = volumes_.next();
  loaded_ = volume.stamp().volume_id;
  const std::int64_t from_ns = now_ns();
  if (auto loaded = renderer_.load(volume); !loaded) return loaded;
  block.volumes.push_back(
      {.volume_id = loaded_, .load = {.begin_ns = from_ns, .end_ns = now_ns()}, .stages = {}});
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
