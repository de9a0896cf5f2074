// SPDX-License-Identifier: Apache-2.0
#include "acquisition/igtl/igtl_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/source/printable.hpp"
#include "proto/base/clock.hpp"
#include "proto/base/printable.hpp"
#include "proto/exchange/pulse.hpp"
#include "proto/igtl/pose_bodies.hpp"
#include "proto/igtl/timestamp.hpp"

namespace fanlight {

namespace {

using igtl::OpenedMessage;

// A larger gap of FrameIndex is a different numbering and no loss.
constexpr std::uint32_t kMostLost = 1000;
// A knock at the tracker is no other fan.
constexpr std::int64_t kMostOutsideFanNs = 2'000'000'000;
constexpr std::uint32_t kLeastOutsideFan = 20;
// Three sweeps of a hundred and fifty images.
constexpr std::size_t kMostLearnedAgain = 450;

/// PLUS says in the metadata whether a pose is one: NameStatus is OK, or OUT_OF_VIEW, MISSING and others.
bool is_good(const igtl::Metadata& metadata, std::string_view name) {
  bool good = true;
  metadata.for_each([&](std::string_view key, std::string_view value) {
    if (key.size() == name.size() + 6 && key.starts_with(name) && key.ends_with("Status"))
      good = value == "OK";
  });
  return good;
}

}  // namespace

IgtlSource::IgtlSource(const Config& config, ProbeLink& link)
    : config_(config),
      counters_(link.igtl),
      connection_(config.address, config.silence_s, link),
      device_(config.address.image) {}

Result<std::unique_ptr<IgtlSource>> IgtlSource::create(const Config& config, ProbeLink& link) {
  if (!(config.wait_s >= 0)) {
    return Error{ErrorCode::kInvalidArgument,
                 fmt::format("the time to wait for the source is {} s, expected 0 or more", config.wait_s)};
  }
  std::unique_ptr<IgtlSource> made(new IgtlSource(config, link));
  const auto after = [](double seconds) {
    return now_ns() + static_cast<std::int64_t>(std::min(seconds, 1e9) * 1e9);
  };
  const std::int64_t give_up_ns = after(config.wait_s);
  while (!made->connection_.is_open()) {
    if (auto goes_on = made->not_stopped(); !goes_on) return goes_on.error();
    made->connection_.step();
    const std::string& trouble = made->connection_.trouble();
    if (now_ns() >= give_up_ns && !made->connection_.is_open()) {
      return Error{ErrorCode::kNotFound,
                   fmt::format("{}, expected an OpenIGTLink server there",
                               trouble.empty() ? config.address.text() + " does not answer" : trouble)};
    }
  }
  if (auto learned = made->learn_until_known(); !learned) return learned.error();
  return made;
}

// ---- messages

/// The sender's time, ns since 1970; without one, now.
std::int64_t IgtlSource::sender_time_ns() const {
  const std::uint64_t timestamp = connection_.head().timestamp;
  return timestamp == 0 ? now_ns() : static_cast<std::int64_t>(igtl::ns_of(timestamp));
}

/// Incomplete data of the last connection is dropped.
void IgtlSource::begin_connection() {
  if (parts_.abandon()) counters_.images_cut.add();
  poses_.clear();
}

/// Of an image of ours, a frame that is counted; all else is counted as a message alone.
void IgtlSource::take_damaged() {
  counters_.messages_damaged.add();
  const igtl::MessageHead& head = connection_.head();
  if (head.type.view() != "IMAGE" || learning_ || !(head.device == device_)) return;
  (void)parts_.abandon();
  Held& held = free_place();
  held.fault = FrameFault::kDamaged;
  held.image.time_ns = sender_time_ns();
  held.image.notes = {};
  held.arrival_ns = now_ns();
  held.is_there = true;
}

void IgtlSource::take_message() {
  if (std::exchange(connection_of_message_, connection_.number()) != connection_.number()) begin_connection();
  const OpenedMessage opened = igtl::open_message(connection_.head(), connection_.body());
  if (opened.state == OpenedMessage::State::kMalformed) return counters_.messages_malformed.add();
  if (opened.state == OpenedMessage::State::kDamaged) return take_damaged();
  const std::string_view type = connection_.head().type.view();
  if (type == "IMAGE") return take_image(opened);
  constexpr std::size_t kMostNames = 200;
  if (learning_ && seen_.size() < kMostNames && seen_.find(type) == std::string::npos)
    seen_ += fmt::format("{}{}", seen_.empty() ? "" : ", ", type);
  if (use_message(opened)) return counters_.messages_used.add();
  const bool known = type == "TRANSFORM" || type == "TDATA";
  (known ? counters_.messages_malformed : counters_.messages_ignored).add();
}

/// False: it is of no use, or malformed.
bool IgtlSource::use_message(const OpenedMessage& opened) {
  const igtl::QueryType asked = igtl::query_of(connection_.head().type.view());
  if (asked.query == igtl::Query::kReply || asked.type == "STATUS") return true;
  if (asked.query == igtl::Query::kGet && asked.type == "CAPABIL") {
    connection_.send_capability();
    return true;
  }
  if (asked.query != igtl::Query::kNone) return false;
  if (asked.type == "TRANSFORM") {
    const auto pose = igtl::parse_transform(opened.content);
    if (pose && is_good(opened.metadata, "Transform")) add_pose(connection_.head().device, *pose);
    return pose.has_value();
  }
  if (asked.type != "TDATA") return false;
  for (std::size_t i = 0; i < igtl::tool_count(opened.content); ++i) {
    const auto tool = igtl::parse_tool(opened.content, i);
    if (!tool) return false;
    if (is_good(opened.metadata, tool->name.view())) add_pose(tool->name, tool->pose);
  }
  return true;
}

/// Where a device is chosen, the others would take its place.
void IgtlSource::add_pose(const igtl::DeviceName& device, const igtl::GridPose& pose) {
  const std::string& chosen = config_.address.transform;
  if (chosen.empty() || device.view() == chosen) poses_.add(device, sender_time_ns(), pose);
}

void IgtlSource::take_image(const OpenedMessage& opened) {
  const igtl::MessageHead& head = connection_.head();
  const auto image = igtl::parse_image(opened.content);
  if (!image) return counters_.messages_malformed.add();
  if (!device_.empty() && !(head.device == device_)) return counters_.messages_ignored.add();
  const std::string why_not = why_no_frame(image->body);
  if (!why_not.empty() && learning_) {
    seen_ = fmt::format("an IMAGE {}: {}", in_quotes(head.device.view()), why_not);
    return counters_.messages_ignored.add();
  }
  counters_.messages_used.add();
  if (device_.empty()) device_ = head.device;
  Held& held = free_place();
  held.fault = why_not.empty() ? FrameFault::kNone : FrameFault::kMisfit;
  held.image = {.body = image->body,
                .pixels = image->pixels,
                .metadata = opened.metadata,
                .notes = frame_notes(opened.metadata),
                .time_ns = sender_time_ns()};
  held.arrival_ns = now_ns();
  if (held.fault == FrameFault::kNone && !image->body.is_whole()) return take_part(*image, held);
  if (parts_.abandon()) counters_.images_cut.add();
  // What was parsed refers to the memory that now is the held image's.
  connection_.swap_body(held.memory);
  held.is_there = true;
}

/// The last part stands for the image: its time, its metadata, its matrix.
void IgtlSource::take_part(const igtl::ReceivedImage& image, Held& held) {
  const ImageParts::State state = parts_.add(image);
  if (state == ImageParts::State::kCut || state == ImageParts::State::kStray) counters_.images_cut.add();
  if (state != ImageParts::State::kWhole) return;
  held.parts.assign(parts_.pixels().begin(), parts_.pixels().end());
  held.image.pixels = held.parts;
  connection_.swap_body(held.memory);  // the metadata refers to the message
  held.is_there = true;
}

// ---- what the images are

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
        return Error{ErrorCode::kBadInput,
                     fmt::format("{}: no usable image in {} s, expected an IMAGE with 2D grey levels; "
                                 "received: {}",
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
  shape_ = ImageShape::of(held_.image);
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
  fan.source.origin = FrameOrigin::kUnknown;
  fan.source.largest_frame_bytes = most_frame_bytes_;
  fan_ = std::move(fan);
  levels_ = fan_.format.is_grey() ? std::nullopt : std::optional(GreyLevels(fan_.format, fan_.window));
  grey_.resize(bytes);
  learning_.reset();
  return {};
}

/// Images that cannot be interpreted now may be so later: the source continues.
bool IgtlSource::learn_again() {
  const auto known = learn_of_held(false);
  if (known) {
    if (*known) connection_.report_trouble("");
    // Images of the way to another place are no part of its fan.
    if (!*known && learning_->images() >= kMostLearnedAgain) {
      const auto why_not = learning_->result(true);
      if (!why_not) connection_.report_trouble(why_not.error().message);
      begin_to_learn();
    }
    return *known;
  }
  connection_.report_trouble(known.error().message);
  begin_to_learn();
  return false;
}

// ---- frames

Result<std::optional<FrameStamp>> IgtlSource::next_frame(std::stop_token stop) {
  thread_owner_.check();
  while (!stop.stop_requested()) {
    Pulse::beat();
    if (std::exchange(was_announced_, false)) forget_held();
    if (held_.is_there && held_.fault == FrameFault::kNone) {
      if (!learning_ && !ImageShape::of(held_.image).matches(shape_)) {
        if (held_.image.body.size[0] * std::uint64_t{held_.image.body.size[1]} > most_frame_bytes_) {
          held_.fault = FrameFault::kMisfit;
        } else {
          begin_to_learn();
        }
      }
      if (learning_ && !learn_again()) {
        forget_held();
        continue;
      }
    }
    if (held_.is_there && announce()) return std::optional(announced_.stamp);
    if (connection_.step() == IgtlConnection::Event::kMessage) take_message();
  }
  return std::optional<FrameStamp>{};
}

void IgtlSource::forget_held() {
  held_.is_there = false;
  if (next_.is_there) std::swap(held_, next_);
}

IgtlSource::Placed IgtlSource::placed(const IgtlImage& image) const {
  if (fan_.angles == LearnedFan::Angles::kNamed) return {.angle_rad = image.notes.angle_rad};
  igtl::GridPose grid = image.body.pose;
  if (fan_.angles == LearnedFan::Angles::kTransforms) {
    const auto device = poses_.find(fan_.device.view());
    if (!device) return {.may_come = true};
    const auto answer = poses_.at(*device, image.time_ns);
    if (!answer.pose || (answer.may_come && !next_.is_there)) return {.may_come = answer.may_come};
    grid = igtl::composed(*answer.pose, grid);
  }
  const FrameSize size = frame_size(image.body, config_.address.orientation);
  const auto pose = frame_pose(grid, config_.address.orientation, size);
  const auto place = pose ? place_in_fan(fan_.fit, *pose, fan_.centre_column) : std::nullopt;
  if (!place || !lies_in_fan(*place)) return {.is_outside_fan = true};
  return {.angle_rad = place->angle_rad};
}

bool IgtlSource::announce() {
  double angle_rad = 0;
  FrameFault fault = held_.fault;
  if (fault == FrameFault::kNone) {
    const Placed place = placed(held_.image);
    const bool waits = place.may_come && !next_.is_there && connection_.is_open();
    if (waits) return false;
    if (!place.angle_rad) counters_.images_not_placed.add();
    outside_fan_ = place.is_outside_fan ? outside_fan_ + 1 : 0;
    if (place.is_outside_fan) look_for_another_fan();
    if (!place.angle_rad || held_.image.notes.is_invalid) fault = FrameFault::kInvalid;
    angle_rad = place.angle_rad.value_or(0);
  }
  announced_ = {.stamp = stamp_of(held_.image.notes, angle_rad), .fault = fault};
  was_announced_ = true;
  return true;
}

/// Where one image after the other lies outside of the fan, the tracker's frame of reference has changed: the
/// fan is determined again.
void IgtlSource::look_for_another_fan() {
  if (outside_fan_ == 1) outside_fan_since_ns_ = held_.arrival_ns;
  if (outside_fan_ < kLeastOutsideFan || held_.arrival_ns - outside_fan_since_ns_ < kMostOutsideFanNs) return;
  outside_fan_ = 0;
  connection_.report_trouble("The images are in another place than before. Looking for their fan again.");
  begin_to_learn();
}

FrameStamp IgtlSource::stamp_of(const FrameNotes& notes, double angle_rad) {
  const bool damaged = held_.fault == FrameFault::kDamaged;
  const std::uint64_t connection = connection_.number();
  const bool is_first = std::exchange(connection_of_last_, connection) != connection;
  const std::uint64_t sequence = sequence_of(notes, is_first);
  FrameStamp stamp{
      .sequence = sequence,
      .volume_index = damaged ? announced_.stamp.volume_index
                              : volume_.continued(notes.volume_index.value_or(0), is_first),
      .frame_index = notes.frame_index.value_or(0),
      .frames_in_sweep = notes.frames_in_sweep.value_or(0),
      .direction = direction_of(notes, angle_rad),
      .angle_rad = angle_rad,
      .geometry_revision = geometry_revision_,
      .after_interruption = notes.after_interruption,
      .capture_time_ns = held_.arrival_ns,
  };
  // The clocks of both ends are compared across connections: what is late after a loss looks late.
  if (is_first && connection > 1) stamp.after_interruption = true;
  if (!damaged) {
    stamp.capture_time_ns = capture_time_ns(notes);
    connection_.report_origin(notes.origin);
    last_ = notes;
    last_angle_rad_ = angle_rad;
  } else if (last_.frame_index) {
    ++*last_.frame_index;  // it came, so that it is not missing
  }
  return stamp;
}

std::int64_t IgtlSource::capture_time_ns(const FrameNotes& notes) {
  const std::int64_t by_clocks_ns =
      clock_.host_time_ns(static_cast<std::uint64_t>(held_.image.time_ns), held_.arrival_ns);
  // A sender whose own frames are late says so: no comparison of clocks shows that from the first frame on.
  const std::int64_t by_sender_ns = held_.arrival_ns - std::int64_t{notes.age_ms.value_or(0)} * 1'000'000;
  return std::min(by_clocks_ns, by_sender_ns);
}

/// By the sender's own count, or by arrival and the gaps of its indices.
std::uint64_t IgtlSource::sequence_of(const FrameNotes& notes, bool is_first) {
  if (fan_.sequence_named) {
    return notes.sequence ? sequence_.continued(*notes.sequence, is_first) : announced_.stamp.sequence + 1;
  }
  const bool same_sweep = notes.volume_index && notes.volume_index == last_.volume_index;
  if (same_sweep && notes.frame_index && last_.frame_index && *notes.frame_index > *last_.frame_index) {
    const std::uint32_t lost = *notes.frame_index - *last_.frame_index - 1;
    if (lost < kMostLost) arrivals_ += lost;
  }
  return arrivals_++;
}

/// As it is named. Otherwise as the angle moves within the sweep; a new sweep near the place where the last
/// one ended goes the other way, and one that begins elsewhere goes the same.
SweepDirection IgtlSource::direction_of(const FrameNotes& notes, double angle_rad) {
  if (notes.direction) return direction_ = *notes.direction;
  const double moved_rad = angle_rad - last_angle_rad_;
  if (notes.volume_index == last_.volume_index) {
    if (moved_rad > 0) direction_ = SweepDirection::kForward;
    if (moved_rad < 0) direction_ = SweepDirection::kBackward;
    return direction_;
  }
  const double range_rad = fan_.source.last_angle_rad - fan_.source.first_angle_rad;
  if (std::abs(moved_rad) > range_rad / 2) return direction_;
  const bool upper_end = angle_rad > (fan_.source.first_angle_rad + fan_.source.last_angle_rad) / 2;
  return direction_ = upper_end ? SweepDirection::kBackward : SweepDirection::kForward;
}

FrameFault IgtlSource::read_pixels(std::span<std::uint8_t> pixels, std::stop_token) {
  thread_owner_.check();
  const IgtlImage& image = held_.image;
  const FrameSize size = frame_size(image.body, config_.address.orientation);
  std::span<const std::uint8_t> grey = image.pixels;
  if (levels_) {
    levels_->convert(image.pixels, grey_);
    grey = grey_;
  }
  if (config_.address.orientation == ImageOrientation{}) {
    std::ranges::copy(grey, pixels.begin());
  } else {
    arrange_frame(grey, config_.address.orientation, size, pixels);
  }
  return FrameFault::kNone;
}

}  // namespace fanlight
