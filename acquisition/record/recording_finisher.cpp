// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recording_finisher.hpp"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

namespace fanlight {

namespace {

/// Packing and copying take the time that the renderer leaves.
void lower_priority() {
  constexpr int kNice = 10;
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kNice);
}

/// Whether a copy of the pixels leaves the disk enough for what is recorded meanwhile.
bool has_room_for_copy(const RecordingFinisher::Job& job) {
  constexpr std::uint64_t kReserveBytes = 128'000'000;
  std::uint64_t bytes = kReserveBytes;
  std::error_code failure;
  for (const SegmentPaths& each : job.segments) {
    const auto size = std::filesystem::file_size(each.pixels, failure);
    if (!failure) bytes += size;
  }
  const auto folder = job.path.has_parent_path() ? job.path.parent_path() : std::filesystem::path(".");
  const auto disk = std::filesystem::space(folder, failure);
  return failure || disk.available >= bytes;
}

/// Removes segments without a frame. Where there are pixels without a record of them, they stay for a person.
void remove_empty(const std::vector<SegmentPaths>& segments) {
  std::error_code failure;
  const bool empty = std::ranges::all_of(segments, [&failure](const SegmentPaths& each) {
    const auto bytes = std::filesystem::file_size(each.pixels, failure);
    return failure || bytes == 0;
  });
  if (empty) remove_segments(segments);
}

/// Where there is no room for a copy of the pixels, they stay in the file that they are in.
Result<FinishedRecording> finish(const RecordingFinisher::Job& job, FinishProgress& progress,
                                 const std::stop_token& stop) {
  const bool copies = job.path.extension() == ".mha";
  if (!copies || job.segments.size() > 1 || has_room_for_copy(job)) {
    auto finished = finish_recording(job.segments, job.path, job.options, progress, stop);
    if (!finished && finished.error().code == ErrorCode::kNotFound) remove_empty(job.segments);
    if (!copies || finished || finished.error().code != ErrorCode::kUnavailable) return finished;
  }
  std::filesystem::path pair = job.path;
  pair.replace_extension(".mhd");
  FinishOptions raw = job.options;
  raw.form = PixelForm::kRaw;
  return finish_recording(job.segments, pair, raw, progress, stop);
}

}  // namespace

void RecordingFinisher::add(Job job) {
  waiting_.push_back(std::move(job));
  if (!running_) start();
}

void RecordingFinisher::start() {
  if (waiting_.empty()) return;
  running_ = std::move(waiting_.front());
  waiting_.pop_front();
  progress_.bytes_done = 0;
  progress_.bytes_in_all = 0;
  result_.reset();
  ended_ = false;
  try {
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  } catch (const std::system_error&) {
    result_ =
        Error{ErrorCode::kUnavailable, "the system has no thread to finish the recording, expected one"};
    ended_ = true;
    bell_.ring();
  }
}

void RecordingFinisher::run(const std::stop_token& stop) {
  lower_priority();
  try {
    result_ = finish(*running_, progress_, stop);
  } catch (const std::exception& thrown) {  // no memory, or a library's
    result_ = Error{ErrorCode::kUnavailable,
                    fmt::format("the recording could not be finished ({}), expected memory and a sound disk",
                                thrown.what())};
  }
  ended_.store(true, std::memory_order_release);
  bell_.ring();
}

std::optional<RecordingFinisher::Outcome> RecordingFinisher::poll() {
  if (!running_ || !ended_.load(std::memory_order_acquire)) return std::nullopt;
  if (thread_.joinable()) thread_.join();
  Outcome outcome{.job = *std::exchange(running_, std::nullopt), .result = *std::move(result_)};
  start();
  return outcome;
}

double RecordingFinisher::share() const {
  const auto all = static_cast<double>(progress_.bytes_in_all.load());
  return all > 0 ? std::min(1.0, static_cast<double>(progress_.bytes_done.load()) / all) : 0;
}

void RecordingFinisher::leave() {
  waiting_.clear();
  if (!running_) return;
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  running_.reset();
}

}  // namespace fanlight
