// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_volumes.hpp"

#include <spdlog/spdlog.h>

#include <atomic>
#include <new>
#include <utility>

#include "acquisition/convert/grid_volume.hpp"
#include "proto/base/clock.hpp"
#include "proto/igtl/image_body.hpp"

namespace fanlight {

namespace {

/// Takes the memory of the voxels.
std::vector<std::uint8_t> image_of(GridVolume grid) {
  const double step_mm = grid.spacing_mm;
  igtl::ImageBody image{.pose = {.i_mm = {step_mm, 0, 0},
                                 .j_mm = {0, step_mm, 0},
                                 .k_mm = {0, 0, step_mm},
                                 .first_mm = grid.origin_mm}};
  for (std::size_t axis = 0; axis < 3; ++axis)
    image.size[axis] = image.part_size[axis] = static_cast<std::uint16_t>(grid.size[axis]);
  std::vector<std::uint8_t> header;
  igtl::put_image_header(header, image);
  std::vector<std::uint8_t> content = std::move(grid.voxels);
  content.insert(content.begin(), header.begin(), header.end());
  return content;
}

}  // namespace

/// What a thread of the background lane does for one volume. The server looks at it when it is done.
struct IgtlVolumes::Job {
  std::function<void(Job& job)> work;
  std::shared_ptr<Volume> volume;
  IgtlMessages messages;
  std::string trouble;  // empty: none
  std::atomic<bool> stopped{false};
  bool is_orphan = false;  // there is no one left to notify

  void run() {
    try {
      work(*this);
    } catch (const std::bad_alloc&) {
      trouble = "there is no memory for it, expected a larger --igtl-spacing";
    }
  }
};

void IgtlVolumes::order(const IgtlWanted& wanted, std::uint64_t volume_id) {
  if (*self_ == nullptr || waits_ || job_ != nullptr || now_ns() < not_before_ns_) return;
  wanted_ = wanted;
  volume_id_ = volume_id;
  is_wanted_ = true;
  waits_ =
      dependencies_.copier.copy(EncoderLane::kBackground, copy_, [self = self_](VolumeCopier::Copy copy) {
        if (*self != nullptr) (*self)->copied(std::move(copy));
      });
  if (!waits_) fail("the renderer has many orders to carry out");
}

void IgtlVolumes::copied(VolumeCopier::Copy copy) {
  waits_ = false;
  copy_ = std::move(copy.volume);
  if (!is_wanted_) return;
  switch (copy.outcome) {
    case VolumeCopier::Outcome::kNoVolume:
      return fail("there is none yet");
    case VolumeCopier::Outcome::kNoMemory:
      return fail("there is no memory for a copy of it");
    case VolumeCopier::Outcome::kBusy:
      return fail("the renderer has many orders to carry out");
    case VolumeCopier::Outcome::kCopied:
      return convert();
  }
}

void IgtlVolumes::convert() {
  const auto job = std::make_shared<Job>();
  job->volume = copy_;
  const std::uint64_t utc_ns = dependencies_.utc_ns(copy_->stamp().last_capture_time_ns);
  job->work = [spacing_mm = spacing_mm_, wanted = wanted_, utc_ns](Job& self) {
    const Volume& volume = *self.volume;
    auto grid = scan_converted(
        volume, spacing_mm > 0 ? spacing_mm : usual_spacing_mm(volume),
        [&self](double) { return !self.stopped.load(std::memory_order_relaxed); }, kMostVoxelsSent);
    if (!grid) {
      self.trouble = grid.error().message + " (--igtl-spacing)";
      return;
    }
    const std::uint64_t id = volume.stamp().volume_id;
    const std::string id_text = std::to_string(id);
    const std::pair<std::string_view, std::string_view> items[] = {{"FanlightVolume", id_text}};
    const IgtlMessageFacts facts{.utc_ns = utc_ns, .id = static_cast<std::uint32_t>(id), .metadata = items};
    self.messages = stream_messages(IgtlStream::kVolume, facts, image_of(*std::move(grid)), wanted);
  };
  run(job, [this, job] {
    told_.clear();
    dependencies_.made(
        {.messages = job->messages, .ordered_id = volume_id_, .shown_id = job->volume->stamp().volume_id});
  });
}

/// `done`: after it went well.
void IgtlVolumes::run(const std::shared_ptr<Job>& job, std::function<void()> done) {
  job_ = job;
  const auto finished = [this, job, done = std::move(done)] {
    if (job->is_orphan) return;
    job_.reset();
    if (job->stopped) return;
    if (job->trouble.empty()) return done();
    fail(job->trouble);
  };
  try {
    dependencies_.executor(
        EncoderLane::kBackground, [job] { job->run(); }, finished);
  } catch (const std::bad_alloc&) {
    job_.reset();  // it was not handed over
    throw;
  }
}

void IgtlVolumes::fail(const std::string& reason) {
  not_before_ns_ = now_ns() + kPauseNs;
  const bool is_new = std::exchange(told_, reason) != reason;
  const std::string trouble = "the volume is not sent: " + reason;
  if (is_new) spdlog::warn("OpenIGTLink: {}", trouble);
  dependencies_.made({.messages = {}, .ordered_id = volume_id_, .trouble = is_new ? trouble : ""});
}

void IgtlVolumes::stop() {
  is_wanted_ = false;
  if (job_ != nullptr) job_->stopped = true;
}

void IgtlVolumes::end() {
  *self_ = nullptr;
  if (job_ != nullptr) job_->is_orphan = true;
  stop();
}

}  // namespace fanlight
