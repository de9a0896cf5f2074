// SPDX-License-Identifier: Apache-2.0
#include "server/bench/memory.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>

#include "acquisition/record/recorder.hpp"
#include "proto/base/clock.hpp"
#include "proto/base/scratch_folder.hpp"
#include "server/bench/rig.hpp"
#include "server/bench/run.hpp"
#include "server/codec/picture_coder.hpp"

namespace fanlight {

namespace {

Result<void> encode_pictures(const Picture& picture, const StreamSettings& settings) {
  constexpr int kPictures = 10;
  const auto coder = make_coder(settings);
  if (!coder) return coder.error();
  for (int number = 0; number < kPictures; ++number) {
    if (auto coded = (*coder)->encode(pixels_of(picture), number == 0); !coded) return coded.error();
  }
  return {};
}

/// Records frames at the rate of a probe: 1000 a second.
Result<void> record_frames(BenchVolumes& volumes, MemoryLedger& ledger) {
  constexpr std::uint32_t kFrames = 500;
  constexpr std::chrono::milliseconds kFrameTime{1};
  const ScratchFolder folder("fanlight-bench");
  if (auto made = folder.check(); !made) return made;
  Doorbell bell;
  Recorder recorder(volumes.description(), bell);
  const RecordingLink link = recorder.link();
  link.send({.number = 1, .wish = RecordingOrder::Wish::kRecord, .path = folder.path() / "memory.igs.mha"});
  const auto trouble = [&link]() -> std::string {
    const RecordingStatus* const status = link.status.newest();
    return status == nullptr ? std::string() : status->trouble;
  };
  const std::int64_t latest_ns = now_ns() + 5'000'000'000;
  while (!recorder.tap().is_open()) {
    if (now_ns() > latest_ns)
      return Error{ErrorCode::kUnavailable, "the recorder does not begin: " + trouble()};
    bell.wait(10'000'000);
  }
  for (std::uint32_t recorded = 0; recorded < kFrames;) {
    const auto frames = volumes.next().stamp().frames;
    for (std::uint32_t index = 0; index < frames && recorded < kFrames; ++index, ++recorded) {
      const QueuedFrame frame = volumes.frame(index);
      recorder.tap().queue().put(frame.stamp, frame.geometry, frame.pixels);
      std::this_thread::sleep_for(kFrameTime);
    }
  }
  ledger.note("recorder");
  recorder.end(Recorder::Finish::kLeave);
  if (const std::uint64_t missed = recorder.tap().frames_missed(); missed > 0) {
    return Error{ErrorCode::kUnavailable, "the recorder had no room for " + std::to_string(missed) +
                                              " frames, expected a faster disk"};
  }
  return {};
}

/// What a server may have besides the main view.
Result<void> add_others(BenchRig& rig, BenchVolumes& volumes, MemoryLedger& ledger) {
  if (auto drawn = rig.private_pictures(1, BenchRig::PrivateKind::kCamera); !drawn) return drawn.error();
  ledger.note("private view, own camera");
  if (auto coded = encode_pictures(rig.picture(), {.codec = StreamSettings::Codec::kJpeg, .quality = 85});
      !coded)
    return coded;
  ledger.note("encoder, JPEG");
  if (auto coded = encode_pictures(
          rig.picture(), {.codec = StreamSettings::Codec::kH264, .bit_rate_kbps = 4000, .rate_hz = 30});
      !coded)
    return coded;
  ledger.note("encoder, H.264");
  return record_frames(volumes, ledger);
}

}  // namespace

Result<void> run_bench_memory(const RenderDevice& device, const BenchRow& row, std::uint64_t volumes,
                              MemoryLedger& ledger, const std::function<void(const HeldMemory&)>& tell) {
  constexpr std::uint32_t kRing = 4;
  constexpr std::uint64_t kWarmUp = 10;
  auto work = BenchWork::create(row, kRing);
  if (!work) return work.error();
  ledger.note("ring of four volumes");
  BenchRig rig(device, *work);
  if (auto started = rig.start(Skipping::kOn); !started) return started.error();
  // The renderer accepts frames ahead only for a volume that follows another one.
  if (auto first = rig.whole_volume(); !first) return first.error();
  const std::uint64_t between = std::max<std::uint64_t>((volumes - std::min(volumes, kWarmUp)) / 10, 1);
  for (std::uint64_t done = 1; done <= volumes; ++done) {
    if (auto shown = rig.new_volume(); !shown) return shown.error();
    if (done < kWarmUp || (done - kWarmUp) % between != 0) continue;
    tell({.volumes = done,
          .resident_mb = resident_mb(),
          .own_mb = own_mb(),
          .ring_mb = static_cast<double>(work->volumes.held_bytes()) / 1e6});
  }
  ledger.note("main view");
  return add_others(rig, work->volumes, ledger);
}

}  // namespace fanlight
