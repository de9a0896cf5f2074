// SPDX-License-Identifier: Apache-2.0
#include "acquisition/assembly/open_volume.hpp"

#include <algorithm>
#include <numeric>

#include "proto/model/fan_geometry.hpp"

namespace fanlight {

namespace {

// A motor that stands still gives a volume without thickness, and a division by zero in the angle look-up
// table.
constexpr double kLeastSpreadRad = radians(0.01);

// Marks an index of a frame. A volume has fewer frames.
constexpr std::uint32_t kOutlier = 1U << 31;

}  // namespace

OpenVolume::OpenVolume(VolumeRing& ring, Doorbell& writer_bell)
    : ring_(ring),
      writer_bell_(writer_bell),
      stamps_(ring.frame_capacity()),
      angle_check_(ring.frame_capacity()) {
  by_sequence_.reserve(stamps_.size());
  frames_to_check_.reserve(stamps_.size());
}

bool OpenVolume::open(const FanGeometry& geometry, const std::stop_token& stop) {
  Volume* const volume = wait_for_volume(stop);
  if (volume == nullptr) return false;
  if (!volume->holds(geometry)) {
    ring_.abandon();
    return false;
  }
  volume->set_geometry(geometry);
  volume_ = volume;
  return true;
}

Volume* OpenVolume::wait_for_volume(const std::stop_token& stop) {
  Volume* volume = ring_.begin();
  if (volume != nullptr) return volume;
  const std::stop_callback wake(stop, [this] { writer_bell_.ring(); });
  while (!stop.stop_requested()) {
    volume = ring_.begin();
    if (volume != nullptr) return volume;
    writer_bell_.wait(-1);
  }
  return nullptr;
}

void OpenVolume::add(const FrameStamp& frame) {
  stamps_[volume_->stamp().frames] = frame;
  volume_->add_frame(frame);
}

OpenVolume::Angles OpenVolume::remove_outliers() {
  // In order of capture: the findings name indices of by_sequence_.
  by_sequence_.resize(frames());
  std::iota(by_sequence_.begin(), by_sequence_.end(), 0U);
  std::ranges::sort(by_sequence_, {}, [this](std::uint32_t index) { return stamps_[index].sequence; });
  frames_to_check_.clear();
  for (const std::uint32_t index : by_sequence_)
    frames_to_check_.push_back({.sequence = stamps_[index].sequence, .angle_rad = stamps_[index].angle_rad});
  Angles angles{.findings = angle_check_.check(frames_to_check_)};
  const auto& outliers = angles.findings.outliers;
  if (outliers.empty()) return angles;
  angles.removed = static_cast<std::uint32_t>(outliers.size());
  std::uint64_t run = 0;
  for (std::size_t i = 0; i < outliers.size(); ++i) {
    run = i > 0 && outliers[i] == outliers[i - 1] + 1 ? run + 1 : 1;
    angles.longest_run = std::max(angles.longest_run, run);
  }
  // From the highest index down: remove_frame() moves the last frame, which is none of them then.
  for (const std::size_t outlier : outliers) by_sequence_[outlier] |= kOutlier;
  for (std::uint32_t index = frames(); index-- > 0;) {
    if (std::ranges::find(by_sequence_, index | kOutlier) == by_sequence_.end()) continue;
    volume_->remove_frame(index);
    stamps_[index] = stamps_[frames()];
  }
  const auto [first, last] = std::ranges::minmax_element(stamps(), {}, &FrameStamp::sequence);
  volume_->set_span(*first, *last);
  return angles;
}

bool OpenVolume::has_moved() const {
  const auto [smallest, largest] = std::ranges::minmax(volume_->angles_rad());
  return largest - smallest >= kLeastSpreadRad;
}

OpenVolume::Rest OpenVolume::cut(std::uint32_t kept) {
  const Rest rest{.volume = *volume_, .first = kept, .frames = frames() - kept};
  volume_->keep_first(kept, *std::ranges::max_element(stamps().first(kept), {}, &FrameStamp::sequence));
  return rest;
}

bool OpenVolume::carry_over(const Rest& rest, const std::stop_token& stop) {
  // The ring may lend the volume to the reader meanwhile, but overwrites it only by returning it from
  // begin(). In that case the frames are moved to the front of the same volume.
  volume_ = wait_for_volume(stop);
  if (volume_ == nullptr) return false;
  volume_->set_geometry(rest.volume.geometry());
  for (std::uint32_t i = 0; i < rest.frames; ++i) {
    std::ranges::copy(rest.volume.frame_pixels(rest.first + i), volume_->next_frame_pixels().begin());
    add(stamps_[rest.first + i]);
  }
  return true;
}

void OpenVolume::publish() {
  volume_ = nullptr;
  ring_.publish();
}

void OpenVolume::abandon() {
  volume_ = nullptr;
  ring_.abandon();
}

}  // namespace fanlight
