// SPDX-License-Identifier: Apache-2.0
// IgtlSource: how it finds out what the images are.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/igtl/igtl_source.hpp"
#include "proto/base/clock.hpp"
#include "proto/base/crc64.hpp"
#include "proto/base/printable.hpp"

namespace fanlight {

namespace {

// Lengths of one matrix differ in the last bits of its numbers.
constexpr double kSamePixelShare = 1e-3;
// Three sweeps of a hundred and fifty images.
constexpr std::size_t kMostLearnedAgain = 450;

std::array<double, 2> pixel_mm(const igtl::GridPose& pose) {
  return {std::hypot(pose.i_mm[0], pose.i_mm[1], pose.i_mm[2]),
          std::hypot(pose.j_mm[0], pose.j_mm[1], pose.j_mm[2])};
}

/// Checksum of the fields that describe the geometry of all frames.
std::uint64_t told_by(const igtl::Metadata& metadata) {
  std::uint64_t sum = 0;
  const auto add = [&sum](std::string_view text) {
    sum = crc64({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, sum);
  };
  metadata.for_each([&](std::string_view name, std::string_view value) {
    if (!name.starts_with("Fanlight")) return;
    add(name);
    add(value);
  });
  return sum;
}

}  // namespace

Result<void> IgtlSource::not_stopped() const {
  if (!config_.stopped || !config_.stopped()) return {};
  return Error{ErrorCode::kStopped,
               fmt::format("{}: stopped before its images were known", config_.address.text())};
}

std::string IgtlSource::what_came() const {
  std::string text = printable(seen_);
  const auto add = [&text](const Counter& count, const char* what) {
    if (count.value() > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count.value(), what);
  };
  add(counters_.messages_damaged, "messages with a wrong checksum");
  add(counters_.messages_malformed, "messages whose content contradicts their type or length");
  add(counters_.messages_too_long, "messages longer than any image");
  add(counters_.places_lost, "times bytes that are no OpenIGTLink");
  return text.empty() ? "nothing" : text;
}

void IgtlSource::begin_to_learn() {
  learning_.emplace(config_.address, config_.geometry_path, poses_);
  seen_.clear();
}

Result<void> IgtlSource::learn_until_known() {
  begin_to_learn();
  const std::int64_t give_up_ns = now_ns() + static_cast<std::int64_t>(std::min(config_.learn_s, 1e9) * 1e9);
  for (;;) {
    const bool late = now_ns() >= give_up_ns;
    if (auto goes_on = not_stopped(); !goes_on) return goes_on.error();
    if (connection_.step() == IgtlConnection::Event::kMessage) take_message();
    if (held_.is_there) {
      const auto known = learn_of_held(late);
      if (!known) return known.error();
      if (*known) return {};
      forget_held();
    } else if (late) {
      // An image that came last stays among those that were seen.
      if (learning_->images() == 0) {
        return Error{
            ErrorCode::kBadInput,
            fmt::format("{}: no image that can be used came in {} s, expected an IMAGE with 2D grey levels; "
                        "what came: {}",
                        config_.address.text(), config_.learn_s, what_came())};
      }
      auto fan = learning_->result(true);
      if (!fan) return fan.error();
      return use(**std::move(fan));
    }
  }
}

Result<bool> IgtlSource::learn_of_held(bool at_once) {
  if (held_.fault != FrameFault::kNone) return false;
  shape_ = shape_of(held_.image);
  learning_->add(held_.image);
  auto fan = learning_->result(at_once);
  if (!fan) return fan.error();
  if (!*fan) {
    counters_.images_before_fan.add();
    return false;
  }
  if (auto used = use(**std::move(fan)); !used) return used.error();
  // A Fanlight's images are frames from the first one on. The others were looked at, this one too.
  return true;
}

Result<void> IgtlSource::use(LearnedFan fan) {
  const bool first = most_frame_bytes_ == 0;
  const std::uint64_t bytes = fan.source.geometry.frame_bytes();
  if (!first && fan.source.counts_volumes != fan_.source.counts_volumes) {
    return Error{ErrorCode::kUnsupported,
                 fmt::format("{}: the images {} count their volumes now, expected the same as at the start",
                             config_.address.text(), fan.source.counts_volumes ? "do" : "do not")};
  }
  if (first) {
    most_frame_bytes_ = bytes;
  } else {
    ++geometry_revision_;
    // The ring was made for the first geometry.
    fan.source.frames_per_volume = fan_.source.frames_per_volume;
  }
  fan.source.name = config_.address.text();
  fan.source.largest_frame_bytes = most_frame_bytes_;
  fan_ = std::move(fan);
  levels_ = fan_.format.is_grey() ? std::nullopt : std::optional(GreyLevels(fan_.format, fan_.window));
  grey_.resize(bytes);
  learning_.reset();
  return {};
}

IgtlSource::Shape IgtlSource::shape_of(const IgtlImage& image) const {
  return {.size = image.body.size,
          .format = *pixel_format(image.body),
          .pixel_mm = pixel_mm(image.body.pose),
          .told = told_by(image.metadata)};
}

bool IgtlSource::has_new_shape() const {
  const Shape now = shape_of(held_.image);
  const auto differs = [](double one, double other) {
    return std::abs(one - other) > kSamePixelShare * std::max(one, other);
  };
  return now.size != shape_.size || now.format != shape_.format || now.told != shape_.told ||
         differs(now.pixel_mm[0], shape_.pixel_mm[0]) || differs(now.pixel_mm[1], shape_.pixel_mm[1]);
}

/// Images that do not tell what they are now may do so later: the source goes on.
bool IgtlSource::learn_again() {
  const auto known = learn_of_held(false);
  if (known) {
    if (*known) connection_.tell_trouble("");
    // Images of the way to another place are no part of its fan.
    if (!*known && learning_->images() >= kMostLearnedAgain) {
      const auto why_not = learning_->result(true);
      if (!why_not) connection_.tell_trouble(why_not.error().message);
      begin_to_learn();
    }
    return *known;
  }
  connection_.tell_trouble(known.error().message);
  begin_to_learn();
  return false;
}

}  // namespace fanlight
