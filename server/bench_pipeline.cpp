#include "server/bench_pipeline.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "proto/clock.hpp"
#include "proto/doorbell.hpp"
#include "proto/mailbox.hpp"
#include "renderer/renderer.hpp"
#include "server/bench_run.hpp"
#include "server/bench_volumes.hpp"
#include "server/jpeg_coder.hpp"

namespace fanlight {

namespace {

constexpr int kJpegQuality = 85;             // that of `fanlight serve`
constexpr std::int64_t kLookNs = 2'000'000;  // the render thread's

/// One volume's way. The stages are on the device's clock, the rest on the processor's.
struct Walk {
  std::uint64_t volume_id = 0;
  StageSpan load;
  std::array<StageSpan, kStages> stages;
  std::int64_t finished_ns = 0;
};

/// When a picture was encoded.
struct Encoding {
  std::uint64_t volume_id = 0;
  StageSpan span;
};

struct Block {
  std::vector<Walk> walks;
  std::vector<Encoding> encodings;
};

StageSpan together(const Walk& walk, Stage first, Stage last) {
  StageSpan all;
  for (auto stage = static_cast<std::size_t>(first); stage <= static_cast<std::size_t>(last); ++stage) {
    const StageSpan& span = walk.stages[stage];
    if (span.end_ns == 0) continue;
    if (all.end_ns == 0) all.begin_ns = span.begin_ns;
    all.end_ns = span.end_ns;
  }
  return all;
}

std::int64_t processor_ns() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto ns = [](const timeval& time) { return time.tv_sec * 1'000'000'000 + time.tv_usec * 1'000; };
  return ns(used.ru_utime) + ns(used.ru_stime);
}

/// Adds up how much of some spans lies within others.
class Share {
 public:
  void add(const StageSpan& span, std::vector<StageSpan> others) {
    std::ranges::sort(others, {}, &StageSpan::begin_ns);
    std::int64_t covered_to_ns = span.begin_ns;
    for (const StageSpan& other : others) {
      const std::int64_t from_ns = std::max(other.begin_ns, covered_to_ns);
      const std::int64_t to_ns = std::min(other.end_ns, span.end_ns);
      if (to_ns <= from_ns) continue;
      within_ns_ += to_ns - from_ns;
      covered_to_ns = to_ns;
    }
    all_ns_ += span.end_ns - span.begin_ns;
  }
  double value() const {
    return all_ns_ == 0 ? 0 : static_cast<double>(within_ns_) / static_cast<double>(all_ns_);
  }

 private:
  std::int64_t within_ns_ = 0;
  std::int64_t all_ns_ = 0;
};

struct Shares {
  Share light_in_cast;
  Share light_in_work;
  Share upload_in_work;
  Share read_back_in_work;
  Share encoding_in_work;

  void add(const Block& block) {
    // What the device's clock shows when the processor's shows 0: no picture is found before it is there.
    std::int64_t ahead_ns = INT64_MIN;
    for (const Walk& walk : block.walks) {
      ahead_ns = std::max(ahead_ns,
                          walk.stages[static_cast<std::size_t>(Stage::kReadBack)].end_ns - walk.finished_ns);
    }
    const auto on_device = [&](const StageSpan& span) {
      return StageSpan{.begin_ns = span.begin_ns + ahead_ns, .end_ns = span.end_ns + ahead_ns};
    };
    for (const Walk& walk : block.walks) {
      const StageSpan light = together(walk, Stage::kFilter, Stage::kFinish);
      light_in_cast.add(light, others(block, walk.volume_id, {{Stage::kCast, Stage::kCast}}));
      light_in_work.add(light, others(block, walk.volume_id, {{Stage::kPrepare, Stage::kCast}}));
      const auto work = others(block, walk.volume_id, kAllWork);
      upload_in_work.add(on_device(walk.load), work);
      upload_in_work.add(walk.stages[static_cast<std::size_t>(Stage::kUpload)], work);
      read_back_in_work.add(walk.stages[static_cast<std::size_t>(Stage::kReadBack)], work);
    }
    for (const Encoding& encoding : block.encodings) {
      encoding_in_work.add(on_device(encoding.span), others(block, encoding.volume_id, kAllWork));
    }
  }

 private:
  using Stretches = std::vector<std::pair<Stage, Stage>>;
  inline static const Stretches kAllWork = {{Stage::kPrepare, Stage::kCast},
                                            {Stage::kFilter, Stage::kReadBack}};

  static std::vector<StageSpan> others(const Block& block, std::uint64_t volume_id,
                                       const Stretches& stretches) {
    std::vector<StageSpan> spans;
    for (const Walk& walk : block.walks) {
      if (walk.volume_id == volume_id) continue;
      for (const auto& [first, last] : stretches) spans.push_back(together(walk, first, last));
    }
    return spans;
  }
};

/// Encodes pictures on a thread of its own, the newest that there is; ends after that of the last volume.
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

  /// Waits for the last picture, which has been published.
  Result<std::vector<Encoding>> join() {
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
  JpegCoder encoder_{kJpegQuality};
  std::vector<Encoding> done_;  // the thread's until it has ended, as is the next
  std::optional<Error> failure_;
  std::jthread thread_;  // last: it uses the others
};

/// A renderer and the volumes that it is shown.
class PipelineRig {
 public:
  PipelineRig(BenchVolumes& volumes, Renderer& renderer) : volumes_(volumes), renderer_(renderer) {}

  Result<Block> serial(int volumes) {
    Block block;
    for (int volume = 0; volume < volumes; ++volume) {
      if (auto loaded = load(block); !loaded) return loaded.error();
      for (;;) {
        if (auto advanced = renderer_.advance(); !advanced) return advanced.error();
        if (renderer_.collect(picture_)) break;
        if (auto waited = renderer_.wait(kLookNs); !waited) return waited.error();
      }
      note(block, picture_);
      const std::int64_t from_ns = now_ns();
      if (auto jpeg = encoder_.encode(pixels_of(picture_), true); !jpeg) return jpeg.error();
      block.encodings.push_back(
          {.volume_id = picture_.stamp.volume.volume_id, .span = {.begin_ns = from_ns, .end_ns = now_ns()}});
    }
    return block;
  }

  Result<Block> pipelined(int volumes) {
    Block block;
    EncodingThread encoder(loaded_ + static_cast<std::uint64_t>(volumes));
    int to_load = volumes;
    for (int to_come = volumes; to_come > 0;) {
      if (to_load > 0 && renderer_.wants_volume()) {
        if (auto loaded = load(block); !loaded) return loaded.error();
        --to_load;
      }
      if (auto advanced = renderer_.advance(); !advanced) return advanced.error();
      if (renderer_.collect(encoder.pictures().draft())) {
        note(block, encoder.pictures().draft());
        encoder.pictures().publish();
        --to_come;
        continue;  // its slot is free now
      }
      if (auto waited = renderer_.wait(kLookNs); !waited) return waited.error();
    }
    auto encodings = encoder.join();
    if (!encodings) return encodings.error();
    block.encodings = std::move(*encodings);
    return block;
  }

 private:
  Result<void> load(Block& block) {
    const Volume& volume = volumes_.next();
    loaded_ = volume.stamp().volume_id;
    const std::int64_t from_ns = now_ns();
    if (auto loaded = renderer_.load(volume); !loaded) return loaded;
    block.walks.push_back(
        {.volume_id = loaded_, .load = {.begin_ns = from_ns, .end_ns = now_ns()}, .stages = {}});
    return {};
  }

  void note(Block& block, const Picture& picture) const {
    const auto walk = std::ranges::find(block.walks, picture.stamp.volume.volume_id, &Walk::volume_id);
    if (walk == block.walks.end()) return;
    walk->stages = renderer_.stage_spans();
    walk->finished_ns = picture.stamp.finished_time_ns;
  }

  BenchVolumes& volumes_;
  Renderer& renderer_;
  JpegCoder encoder_{kJpegQuality};
  Picture picture_;
  std::uint64_t loaded_ = 0;  // the last volume's number
};

void add_block(PipelineFigures& figures, const Block& block) {
  const Encoding& first = block.encodings.front();
  const Encoding& last = block.encodings.back();
  figures.volumes_a_second.push_back(static_cast<double>(last.volume_id - first.volume_id) * 1e9 /
                                     static_cast<double>(last.span.end_ns - first.span.end_ns));
  figures.volumes += block.walks.size();
  figures.encoded += block.encodings.size();
  for (const Walk& walk : block.walks) {
    if (walk.finished_ns == 0) continue;
    ++figures.pictures;
    const std::int64_t ns = walk.stages[static_cast<std::size_t>(Stage::kReadBack)].end_ns -
                            walk.stages[static_cast<std::size_t>(Stage::kCast)].end_ns;
    figures.light_ms.push_back(static_cast<double>(ns) / 1e6);
  }
}

}  // namespace

Result<PipelineTimes> run_bench_pipeline(const Gpu& gpu, const BenchRow& row, int blocks, int volumes) {
  constexpr std::uint32_t kVolumes = 3;
  auto shown = BenchVolumes::create(row, kVolumes);
  if (!shown) return shown.error();
  const SourceDescription& source = shown->description();
  const auto scene = bench_scene(row, source);
  if (!scene) return scene.error();
  const auto side = static_cast<std::uint32_t>(row.picture);
  RenderCounters counters;
  auto renderer = Renderer::create({.size = {side, side},
                                    .geometry = source.geometry,
                                    .first_angle_rad = source.first_angle_rad,
                                    .last_angle_rad = source.last_angle_rad,
                                    .frame_capacity = shown->frame_capacity()},
                                   {.gpu = gpu, .counters = counters}, {.revision = 1, .scene = *scene});
  if (!renderer) return renderer.error();
  PipelineRig rig(*shown, **renderer);

  PipelineTimes times;
  Shares shares;
  struct Way {
    Result<Block> (PipelineRig::*run)(int);
    PipelineFigures& figures;
    std::int64_t wall_ns = 0;
    std::int64_t processor_ns = 0;
  };
  std::array<Way, 2> ways = {
      {{&PipelineRig::serial, times.serial}, {&PipelineRig::pipelined, times.pipelined}}};
  for (int block = 0; block <= blocks; ++block) {
    for (Way& way : ways) {
      const std::int64_t from_ns = now_ns();
      const std::int64_t used_ns = processor_ns();
      const auto done = (rig.*way.run)(volumes + 1);
      if (!done) return done.error();
      if (block == 0) continue;
      way.wall_ns += now_ns() - from_ns;
      way.processor_ns += processor_ns() - used_ns;
      add_block(way.figures, *done);
      if (&way.figures == &times.pipelined) shares.add(*done);
    }
  }
  for (Way& way : ways) {
    way.figures.busy_cores = static_cast<double>(way.processor_ns) / static_cast<double>(way.wall_ns);
  }
  times.light_in_cast = shares.light_in_cast.value();
  times.light_in_work = shares.light_in_work.value();
  times.upload_in_work = shares.upload_in_work.value();
  times.read_back_in_work = shares.read_back_in_work.value();
  times.encoding_in_work = shares.encoding_in_work.value();
  return times;
}

std::span<const std::string_view> pipeline_rows() {
  static constexpr std::array<std::string_view, 2> kRows = {"r1/default", "r1/paper"};
  return kRows;
}

std::string_view pipeline_mechanism(const Gpu& gpu) {
  if (gpu.cast_queue() != gpu.light_queue()) {
    return "two queues of one device: passes 2 and 3 run on one of them, beside pass 1 on the other";
  }
  return "one queue: bands of pass 1 and passes 2 and 3 take turns on it, beside the processor's copies and "
         "encoding";
}

}  // namespace fanlight
