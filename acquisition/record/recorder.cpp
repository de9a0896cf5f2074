// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recorder.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <system_error>
#include <utility>

#include "acquisition/sequence/plus_fields.hpp"
#include "acquisition/source/printable.hpp"

namespace fanlight {

namespace {

// A segment of a ring: the disk holds the ring and one of these.
constexpr double kSegmentsInRing = 8;
constexpr double kShortestSegmentS = 1;
constexpr double kLongestSegmentS = 60;
// Less than this is no room to begin in again: it would be full at once.
constexpr std::uint64_t kLeastRoomBytes = 64'000'000;
constexpr std::string_view kSceneLine = R"({"scene_revision")";

std::uint64_t largest_frame(const SourceDescription& source) {
  return std::max<std::uint64_t>(source.geometry.frame_bytes(), source.largest_frame_bytes);
}

/// Bytes that are free on the disk of a file.
std::uint64_t free_bytes(const std::filesystem::path& path) {
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  struct statvfs disk {};
  return statvfs(folder.c_str(), &disk) == 0 ? std::uint64_t{disk.f_bavail} * disk.f_frsize : 0;
}

/// Of the files in the folder, not of those in folders of it.
std::uint64_t bytes_in(const std::filesystem::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code failure;
  for (std::filesystem::directory_iterator each(folder, failure), end; !failure && each != end;
       each.increment(failure)) {
    std::error_code gone;
    const std::uint64_t size = each->is_regular_file(gone) ? each->file_size(gone) : 0;
    if (!gone) bytes += size;
  }
  return bytes;
}

double gigabytes(std::uint64_t bytes) {
  return static_cast<double>(bytes) / 1e9;
}

/// As the file can hold it: an angle that is no number makes a frame unusable for any assembler.
RecordedFrame recorded(const QueuedFrame& frame) {
  RecordedFrame record{.stamp = frame.stamp, .fault = frame.fault};
  if (!std::isfinite(record.stamp.angle_rad)) {
    record.stamp.angle_rad = 0;
    if (record.usable()) record.fault = FrameFault::kInvalid;
  }
  return record;
}

}  // namespace

Recorder::Recorder(const SourceDescription& source, Doorbell& status_bell)
    : Recorder(source, status_bell, Config()) {}

Recorder::Recorder(const SourceDescription& source, Doorbell& status_bell, Config config)
    : facts_(facts_of(source)),
      config_(std::move(config)),
      tap_(largest_frame(source), bell_),
      status_(status_bell),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

Recorder::~Recorder() {
  end(Finish::kLeave);
}

void Recorder::end(Finish finish) {
  if (!thread_.joinable()) return;
  waits_for_finish_ = finish == Finish::kWait;
  thread_.request_stop();
  bell_.ring();
  thread_.join();
}

void Recorder::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "recorder");
  try {
    if (!config_.folder.empty()) finish_left_overs();
    while (!stop.stop_requested()) {
      const bool more = tap_.queue().front() != nullptr;
      bell_.wait(more ? 0 : waits() ? kFlushNs / 2 : -1);
      work();
    }
    tap_.open(false);
    take_orders();
    drain(tap_.slots());
    take_pictures();
    // The last seconds before an orderly end were not requested; after a crash they are finished.
    close_recording({}, is_ring() && !waits_for_finish_);
    const std::int64_t until_ns = now_ns() + kMostEndNs;
    while (finisher_.busy() && (waits_for_finish_ || now_ns() < until_ns)) {
      bell_.wait(kFlushNs / 10);
      poll_finisher();
      publish_status();
    }
  } catch (const std::exception& thrown) {  // no memory, or a library's
    trouble_ = fmt::format("the recorder has ended ({}), expected memory and a sound disk", thrown.what());
    over_ = true;
    order_.reset();
  }
  tap_.open(false);
  finisher_.leave();
  publish_status();
}

/// One turn: never longer than some frames take to write, so that orders and flushes come in time.
void Recorder::work() {
  constexpr std::uint32_t kFramesATurn = 64;
  take_orders();
  drain(kFramesATurn);
  take_pictures();
  flush_if_due();
  try_again_if_due();
  poll_finisher();
  publish_status();
}

void Recorder::take_orders() {
  while (const auto order = orders_.take()) take(*order);
}

void Recorder::take(const RecordingOrder& order) {
  drain(tap_.slots());  // the frames before the order
  tap_.open(false);
  close_recording(order.end_path, order.drops && is_ring());
  if (order.wish == RecordingOrder::Wish::kRecord) begin(order);
  order_done_ = order.number;
}

void Recorder::begin(const RecordingOrder& order) {
  order_ = order;
  file_number_ = 0;
  frames_ = 0;
  bytes_ = 0;
  first_time_ns_.reset();
  last_time_ns_ = 0;
  missed_before_ = tap_.frames_missed();
  not_written_ = 0;
  used_looked_ns_ = 0;
  trouble_.clear();
  next_file();
  tap_.open(true);
}

/// The frames from now on belong to a further file. Its name is one that nothing has.
void Recorder::next_file() {
  do {
    file_ = file_of_recording(order_->path, ++file_number_);
  } while (!is_free_name(file_));
  frames_in_file_ = 0;
  segment_number_ = 0;
  lock_ = std::make_shared<RecordingLock>(file_);
}

void Recorder::finish_left_overs() {
  for (const std::filesystem::path& path : recordings_with_left_overs(config_.folder)) {
    if (const RecordingLock lock(path); lock.held()) remove_left_overs(path);
  }
  for (const std::filesystem::path& path : unfinished_recordings(config_.folder)) {
    auto lock = std::make_shared<RecordingLock>(path);
    if (!lock->held()) continue;  // another server's
    finisher_.add({.segments = segments_of(path),
                   .path = path,
                   .options = {.form = config_.form, .check_pixels = true},
                   .lock = std::move(lock)});
  }
}

/// The present file gets its final form, under another name where one is given; the recording continues.
void Recorder::finish_file(const std::filesystem::path& end_path) {
  segment_.reset();
  if (segments_.empty()) return;
  std::filesystem::path path = file_;
  if (!end_path.empty() && is_free_name(end_path)) {
    // Its parts get that name too: a crash from now on leaves what was promised.
    lock_ = std::make_shared<RecordingLock>(end_path);
    if (rename_segments(segments_, end_path)) path = end_path;
  }
  finisher_.add({.segments = std::exchange(segments_, {}),
                 .path = path,
                 .options = {.form = order_->form, .last_s = order_->ring_s},
                 .lock = std::move(lock_)});
  begins_ns_.clear();
}

/// Ends the recording under way, if there is one. `end_path`: the name that it gets; empty: its own.
void Recorder::close_recording(const std::filesystem::path& end_path, bool drop) {
  if (!order_) return;
  if (segment_ && !segment_->flush()) {
    trouble_ = "the last quarter of a second could not be written";
    const std::uint64_t lost = segment_->unflushed_frames();
    frames_ -= lost;
    bytes_ -= lost * geometry_.frame_bytes();
    not_written_ += lost;
  }
  if (drop) {
    segment_.reset();
    remove_segments(segments_);
  } else {
    finish_file(end_path);
  }
  sync_.leave();
  segments_.clear();
  begins_ns_.clear();
  lock_.reset();
  order_.reset();
}

void Recorder::drain(std::uint32_t most_frames) {
  FrameQueue& queue = tap_.queue();
  for (std::uint32_t taken = 0; taken < most_frames; ++taken) {
    const QueuedFrame* const frame = queue.front();
    if (frame == nullptr) return;
    if (order_ && !(trouble_.empty() && write(*frame))) ++not_written_;
    queue.pop();
  }
}

bool Recorder::write(const QueuedFrame& frame) {
  const bool changed =
      segment_ && (frame.stamp.geometry_revision != revision_ || frame.geometry != geometry_);
  if (changed || (!is_ring() && frames_in_file_ == kMostFramesAFile)) {
    if (segment_) {
      if (auto flushed = segment_->flush(); !flushed) {
        stop_for(flushed.error());
        return false;
      }
    }
    if (is_ring()) {
      // Frames of two geometries are no sequence, and the older ones were not requested.
      segment_.reset();
      remove_segments(std::exchange(segments_, {}));
      begins_ns_.clear();
    } else {
      finish_file({});
      next_file();
    }
  }
  if (!segment_ && !open_segment(frame)) return false;
  const RecordedFrame record = recorded(frame);
  if (auto appended = segment_->append(record, frame.pixels); !appended) {
    stop_for(appended.error());
    return false;
  }
  if (segment_->frames() == 1) begins_ns_.push_back(record.stamp.capture_time_ns);
  if (!first_time_ns_) first_time_ns_ = record.stamp.capture_time_ns;
  last_time_ns_ = std::max(last_time_ns_, record.stamp.capture_time_ns);
  ++frames_;
  const bool is_first = frames_in_file_ == 0;
  const std::uint64_t sequence = record.stamp.sequence;
  file_first_sequence_ = is_first ? sequence : std::min(file_first_sequence_, sequence);
  file_last_sequence_ = is_first ? sequence : std::max(file_last_sequence_, sequence);
  ++frames_in_file_;
  bytes_ += geometry_.frame_bytes();
  if (is_ring()) next_segment();
  reached_limit();
  return true;
}

bool Recorder::open_segment(const QueuedFrame& frame) {
  geometry_ = frame.geometry;
  revision_ = frame.stamp.geometry_revision;
  RecordingFacts facts = facts_;
  facts.geometry = geometry_;
  facts.begun_utc_s = utc_now_s();
  auto segment = SegmentWriter::create(segment_paths(file_, ++segment_number_), facts);
  if (!segment) {
    stop_for(segment.error());
    return false;
  }
  segment_ = *std::move(segment);
  segments_.push_back(segment_->paths());
  sync_.follow({segment_->paths().frames, segment_->paths().pixels});
  if (!scene_line_.empty()) (void)segment_->add_picture(scene_line_);
  return true;
}

/// Begins another segment of the ring where the present one is long enough.
void Recorder::next_segment() {
  const double longest_s = std::clamp(order_->ring_s / kSegmentsInRing, kShortestSegmentS, kLongestSegmentS);
  const auto length_ns = segment_->last_time_ns() - segment_->first_time_ns();
  if (static_cast<double>(length_ns) * 1e-9 < longest_s) return;
  if (auto flushed = segment_->flush(); !flushed) return stop_for(flushed.error());
  segment_.reset();
  drop_old_segments();
}

/// Of the ring, the segments that end before its last seconds.
void Recorder::drop_old_segments() {
  const auto from_ns = last_time_ns_ - static_cast<std::int64_t>(order_->ring_s * 1e9);
  std::size_t old = 0;
  while (old + 1 < segments_.size() && begins_ns_[old + 1] < from_ns) ++old;
  remove_segments({segments_.begin(), segments_.begin() + static_cast<std::ptrdiff_t>(old)});
  segments_.erase(segments_.begin(), segments_.begin() + static_cast<std::ptrdiff_t>(old));
  begins_ns_.erase(begins_ns_.begin(), begins_ns_.begin() + static_cast<std::ptrdiff_t>(old));
}

void Recorder::reached_limit() {
  if (!order_) return;
  const double seconds = static_cast<double>(last_time_ns_ - *first_time_ns_) * 1e-9;
  const bool long_enough = order_->most_s > 0 && seconds >= order_->most_s;
  const bool large_enough = order_->most_bytes > 0 && bytes_ + geometry_.frame_bytes() > order_->most_bytes;
  if (!long_enough && !large_enough) return;
  tap_.open(false);
  close_recording({});
}

/// Lines are worth less than frames: one that cannot be written is left out.
void Recorder::take_pictures() {
  while (const auto line = pictures_.take()) {
    if (line->starts_with(kSceneLine)) scene_line_ = *line;
    if (segment_) (void)segment_->add_picture(*line);
  }
}

void Recorder::flush_if_due() {
  const std::int64_t now = now_ns();
  if (!segment_ || now - flushed_ns_ < kFlushNs / 2) return;
  flushed_ns_ = now;
  if (auto flushed = segment_->flush(); !flushed) return stop_for(flushed.error());
  if (const int failure = sync_.take_failure()) {
    return stop_for(
        {ErrorCode::kUnavailable, fmt::format("{} could not be put on its disk ({}), expected a sound disk",
                                              shown(file_), std::generic_category().message(failure))});
  }
  const auto lack = lack_of_room(0);
  if (!lack) return;
  // A ring gets shorter, down to its open segment: fewer seconds are worth more than none.
  if (is_ring() && segments_.size() > 1) return remove_oldest_segment();
  stop_for(*lack);
}

void Recorder::remove_oldest_segment() {
  remove_segments({segments_.begin(), segments_.begin() + 1});
  segments_.erase(segments_.begin());
  begins_ns_.erase(begins_ns_.begin());
}

/// Looks into the folder every ten seconds, and adds what was recorded since: it may have many files.
std::uint64_t Recorder::used_bytes() {
  constexpr std::int64_t kBetweenLooksNs = 10'000'000'000;
  const std::int64_t now = now_ns();
  if (used_looked_ns_ == 0 || now - used_looked_ns_ > kBetweenLooksNs) {
    used_looked_ns_ = now;
    used_bytes_ = bytes_in(config_.folder);
    used_bytes_at_ = bytes_;
  }
  return used_bytes_ + (bytes_ > used_bytes_at_ ? bytes_ - used_bytes_at_ : 0);
}

std::optional<Error> Recorder::lack_of_room(std::uint64_t more_bytes) {
  const std::uint64_t free = free_bytes(file_);
  if (free < config_.reserve_bytes + more_bytes) {
    return Error{ErrorCode::kUnavailable,
                 fmt::format("the disk has {:.2f} GB left, expected {:.2f} GB that recordings leave free",
                             gigabytes(free), gigabytes(config_.reserve_bytes))};
  }
  if (config_.quota_bytes == 0) return std::nullopt;
  // An estimate is not enough to stop for: the folder may have fewer files by now.
  if (used_bytes() + more_bytes > config_.quota_bytes) used_looked_ns_ = 0;
  const std::uint64_t used = used_bytes();
  if (used + more_bytes <= config_.quota_bytes) return std::nullopt;
  return Error{ErrorCode::kUnavailable,
               fmt::format("the recordings take {:.2f} GB, expected at most {:.2f} GB", gigabytes(used),
                           gigabytes(config_.quota_bytes))};
}

/// Nothing more is written until there is room. What was written is finished as far as it goes; a ring is
/// dropped. The tap stays open: what comes is counted.
void Recorder::stop_for(const Error& error) {
  const RecordingOrder order = *order_;
  close_recording({}, is_ring());
  order_ = order;
  trouble_ = error.message;
  room_checked_ns_ = now_ns();
}

void Recorder::try_again_if_due() {
  const std::int64_t now = now_ns();
  if (!postponed_.empty() && now >= next_try_ns_) {
    next_try_ns_ = std::numeric_limits<std::int64_t>::max();  // set when the first of them fails
    for (RecordingFinisher::Job& job : std::exchange(postponed_, {})) finisher_.add(std::move(job));
  }
  if (!order_ || trouble_.empty() || now - room_checked_ns_ < kRoomCheckNs) return;
  room_checked_ns_ = now;
  if (lack_of_room(kLeastRoomBytes)) return;
  trouble_.clear();
  next_try_ns_ = 0;  // there is room for those too
  next_file();
}

void Recorder::poll_finisher() {
  while (auto outcome = finisher_.poll()) {
    const bool again = outcome->job.tries > 0;
    if (!outcome->result && outcome->result.error().code == ErrorCode::kUnavailable) {
      constexpr int kMostDoublings = 6;
      const std::int64_t pause_ns = kRoomCheckNs << std::min(outcome->job.tries++, kMostDoublings);
      next_try_ns_ = std::min(next_try_ns_ == 0 ? std::numeric_limits<std::int64_t>::max() : next_try_ns_,
                              now_ns() + pause_ns);
      postponed_.push_back(outcome->job);
      if (again) continue;  // it was reported
    } else if (!outcome->result && !again) {
      ++lost_;
    }
    tell(*outcome);
  }
}

void Recorder::tell(const RecordingFinisher::Outcome& outcome) {
  ++finished_.finished;
  finished_.last_file = shown(outcome.job.path);
  finished_.last_was_cut_off = outcome.job.options.check_pixels;
  finished_.last_trouble.clear();
  finished_.last_frames = 0;
  finished_.last_bytes = 0;
  finished_.last_duration_s = 0;
  if (const auto& result = outcome.result) {
    finished_.last_file = shown(result->path);
    finished_.last_frames = result->frames;
    finished_.last_bytes = result->bytes;
    finished_.last_duration_s = result->duration_s;
    finished_.last_file_first_sequence = result->first_sequence;
    finished_.last_file_last_sequence = result->last_sequence;
  } else {
    finished_.last_trouble = result.error().message;
  }
}

bool Recorder::status_due() {
  const std::tuple now_known(order_done_, order_.has_value(), trouble_, finisher_.busy(), finished_.finished,
                             postponed_.size(), file_);
  const bool changed = std::exchange(published_, now_known) != now_known;
  const bool moves = order_ || finisher_.busy();
  return changed || (moves && now_ns() - published_ns_ >= kFlushNs);
}

void Recorder::publish_status() {
  if (!status_due()) return;
  published_ns_ = now_ns();
  RecordingStatus& status = status_.draft();
  status = finished_;
  status.order_done = order_done_;
  status.trouble = trouble_;
  status.over = over_;
  status.unfinished = postponed_.size() + lost_;
  if (order_) {
    status.state = trouble_.empty() ? RecordingStatus::State::kRecording : RecordingStatus::State::kNoRoom;
    status.file = shown(file_);
    status.ring = order_->ring_s > 0;
  } else if (finisher_.busy()) {
    status.state = RecordingStatus::State::kFinishing;
    status.file = shown(finisher_.path());
    status.finish_share = finisher_.share();
  }
  status.frames = frames_;
  status.first_sequence = frames_in_file_ > 0 ? file_first_sequence_ : kNoSequence;
  status.last_sequence = file_last_sequence_;
  status.bytes = bytes_;
  status.duration_s = first_time_ns_ ? static_cast<double>(last_time_ns_ - *first_time_ns_) * 1e-9 : 0;
  status.frames_missed = tap_.frames_missed() - missed_before_ + not_written_;
  status_.publish();
}

}  // namespace fanlight
