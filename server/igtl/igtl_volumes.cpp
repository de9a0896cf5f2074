// SPDX-License-Identifier: Apache-2.0
#include "server/igtl/igtl_volumes.hpp"

#include <spdlog/spdlog.h>

#include <atomic>
#include <new>
#include <string>
#include <utility>

#include "acquisition/convert/grid_volume.hpp"
#include "proto/igtl/image_body.hpp"

namespace fanlight {

namespace {

std::vector<std::uint8_t> image_of(const GridVolume& grid) {
  const double step_mm = grid.spacing_mm;
  igtl::ImageBody image{.pose = {.i_mm = {step_mm, 0, 0},
                                 .j_mm = {0, step_mm, 0},
                                 .k_mm = {0, 0, step_mm},
                                 .first_mm = grid.origin_mm}};
  for (std::size_t axis = 0; axis < 3; ++axis)
    image.size[axis] = image.part_size[axis] = static_cast<std::uint16_t>(grid.size[axis]);
  std::vector<std::uint8_t> content;
  content.reserve(igtl::kImageHeaderBytes + grid.voxels.size());
  igtl::put_image_header(content, image);
  content.insert(content.end(), grid.voxels.begin(), grid.voxels.end());
  return content;
}

}  // namespace

/// The conversion of one volume, which a thread of the heavy lane carries out.
struct IgtlVolumes::Job {
  std::shared_ptr<Volume> volume;
  double spacing_mm = 0;  // 0: the usual one
  IgtlWanted wanted;
  std::uint64_t utc_ns = 0;
  std::atomic<bool> stopped{false};
  Result<IgtlMessages> made = IgtlMessages{};

  void run() {
    try {
      made = messages();
    } catch (const std::bad_alloc&) {
      made = Error{ErrorCode::kUnavailable, "there is no memory for its messages"};
    }
  }

 private:
  Result<IgtlMessages> messages() const {
    const auto grid = scan_converted(
        *volume, spacing_mm > 0 ? spacing_mm : usual_spacing_mm(*volume),
        [this](double) { return !stopped.load(std::memory_order_relaxed); }, kMostVoxelsSent);
    if (!grid) return grid.error();
    const std::uint64_t id = volume->stamp().volume_id;
    const std::string id_text = std::to_string(id);
    const std::pair<std::string_view, std::string_view> items[] = {{"FanlightVolume", id_text}};
    const IgtlMessageFacts facts{.utc_ns = utc_ns, .id = static_cast<std::uint32_t>(id), .metadata = items};
    return stream_messages(IgtlStream::kVolume, facts, image_of(*grid), wanted);
  }
};

void IgtlVolumes::order(const IgtlWanted& wanted, std::uint64_t volume_id) {
  if (dependencies_.orders == nullptr || waits_ || job_ != nullptr) return;
  wanted_ = wanted;
  volume_id_ = volume_id;
  send_order();
}

void IgtlVolumes::send_order() {
  waits_ = true;
  dependencies_.orders->draft() = {.number = ++ordered_, .into = copy_};
  dependencies_.orders->publish();
}

void IgtlVolumes::look_for_answer() {
  const VolumeAnswer* const answer =
      dependencies_.answers == nullptr ? nullptr : dependencies_.answers->newest();
  if (answer == nullptr || answer->number != ordered_ || !std::exchange(waits_, false)) return;
  switch (answer->outcome) {
    case VolumeAnswer::Outcome::kNoVolume:
      return;  // the first picture brings a new order
    case VolumeAnswer::Outcome::kTooSmall:
      copy_ = std::make_shared<Volume>(answer->geometry, answer->frames);
      return send_order();
    case VolumeAnswer::Outcome::kCopied:
      return convert();
  }
}

void IgtlVolumes::convert() {
  const auto job = std::make_shared<Job>();
  job->volume = copy_;
  job->spacing_mm = spacing_mm_;
  job->wanted = wanted_;
  job->utc_ns = dependencies_.utc_ns(copy_->stamp().last_capture_time_ns);
  job_ = job;
  const auto done = [this, job] {
    if (!job->stopped) converted(*job);
  };
  try {
    dependencies_.executor(
        EncoderLane::kHeavy, [job] { job->run(); }, done);
  } catch (const std::bad_alloc&) {
    job_.reset();  // it was not handed over
    throw;
  }
}

void IgtlVolumes::converted(Job& job) {
  job_.reset();
  if (job.made) {
    told_ = false;
    dependencies_.made(*job.made, volume_id_);
  } else if (!std::exchange(told_, true)) {
    spdlog::warn("the volume is not sent to OpenIGTLink clients: {}", job.made.error().message);
  }
}

void IgtlVolumes::end() {
  dependencies_.orders = nullptr;
  dependencies_.answers = nullptr;
  if (job_ != nullptr) job_->stopped = true;
}

}  // namespace fanlight
