// SPDX-License-Identifier: Apache-2.0
#include "server/bench/memory.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>

#include "acquisition/record/recorder.hpp"
#include "proto/base/clock.hpp"
#include "server/bench/rig.hpp"
#include "server/bench/run.hpp"
#include "server/codec/picture_coder.hpp"

namespace fanlight {

namespace {

/// The number in a line of proc(5), "VmRSS:   350000 kB", in MB; 0 if there is none.
double line_mb(std::string_view line) {
  const std::size_t digit = line.find_first_of("0123456789");
  double kib = 0;
  if (digit != std::string_view::npos) std::from_chars(line.data() + digit, line.data() + line.size(), kib);
  return kib * 1024 / 1e6;
}

/// The value of a line of /proc/self/status in MB; 0 if the kernel has no such line.
double status_mb(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return line_mb(line);
  }
  return 0;
}

/// RssShmem: Mesa 25 allocates the memory of its devices in files that have no name.
double own_mb() {
  return status_mb("RssAnon") + status_mb("RssShmem");
}

Result<void> encode_pictures(const Picture& picture, const StreamSettings& settings) {
  constexpr int kPictures = 10;
  const auto coder = make_coder(settings);
  if (!coder) return coder.error();
  for (int number = 0; number < kPictures; ++number) {
    if (auto coded = (*coder)->encode(pixels_of(picture), number == 0); !coded) return coded.error();
  }
  return {};
}

/// A new folder for temporary files, which ends with this object, and all that is in it.
class ScratchFolder {
 public:
  static Result<ScratchFolder> create() {
    std::string name = (std::filesystem::temp_directory_path() / "fanlight-bench-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      return Error{ErrorCode::kUnavailable,
                   "there is no folder for temporary files, expected TMPDIR to be one"};
    return ScratchFolder(name);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(ScratchFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  ScratchFolder& operator=(ScratchFolder&&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

/// Records frames at the rate of a probe: 1000 a second.
Result<void> record_frames(BenchVolumes& volumes, MemoryLedger& ledger) {
  constexpr std::uint32_t kFrames = 500;
  constexpr std::chrono::milliseconds kFrameTime{1};
  const auto folder = ScratchFolder::create();
  if (!folder) return folder.error();
  Doorbell bell;
  Recorder recorder(volumes.description(), bell);
  const RecordingLink link = recorder.link();
  link.send({.number = 1, .wish = RecordingOrder::Wish::kRecord, .path = folder->path() / "memory.igs.mha"});
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

void MemoryLedger::note(std::string_view step) {
  const double now_mb = own_mb();
  parts_.push_back({step, now_mb - noted_mb_});
  noted_mb_ = now_mb;
}

std::vector<MemoryPart> file_pages() {
  enum : std::uint8_t { kProgram, kDriver, kLibraries };
  // Mesa's drivers and their compiler, and NVIDIA's.
  constexpr std::array<std::string_view, 4> kDriverNames = {"libLLVM", "/libvulkan_", "nvidia", "libcuda"};
  std::vector<MemoryPart> parts = {
      {"pages of the program"}, {"pages of the driver and its compiler"}, {"pages of other libraries"}};
  std::error_code unknown;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", unknown).string();
  std::ifstream maps("/proc/self/smaps");
  auto kind = kLibraries;
  bool of_file = false;
  double resident_mb = 0;
  for (std::string line; std::getline(maps, line);) {
    // "00400000-0048a000 r-xp 00000000 fd:03 960637  /usr/lib/libLLVM-15.so.1", then a line for each count.
    const bool head = !line.empty() && (std::isdigit(line[0]) != 0 || std::islower(line[0]) != 0);
    if (head) {
      const std::size_t slash = line.find('/');
      of_file = slash != std::string::npos && !line.ends_with("(deleted)");
      const std::string_view path = of_file ? std::string_view(line).substr(slash) : std::string_view();
      const bool driver = std::ranges::any_of(
          kDriverNames, [&](std::string_view name) { return path.find(name) != std::string_view::npos; });
      kind = path == program ? kProgram : driver ? kDriver : kLibraries;
    } else if (of_file && line.starts_with("Rss:")) {
      resident_mb = line_mb(line);
    } else if (of_file && line.starts_with("Anonymous:")) {
      // Written pages of a file are memory of this process.
      parts[kind].mb += resident_mb - line_mb(line);
    }
  }
  return parts;
}

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
          .resident_mb = status_mb("VmRSS"),
          .own_mb = own_mb(),
          .ring_mb = static_cast<double>(work->volumes.held_bytes()) / 1e6});
  }
  ledger.note("main view");
  return add_others(rig, work->volumes, ledger);
}

}  // namespace fanlight
