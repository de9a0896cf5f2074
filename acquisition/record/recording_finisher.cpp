// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recording_finisher.hpp"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <new>
#include <utility>

namespace fanlight {

namespace {

/// Packing and copying take the time that the renderer leaves.
void lower_priority() {
  constexpr int kNice = 10;
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kNice);
}

/// Where there is no room for a copy of the pixels, they stay in the file that they are in.
Result<FinishedRecording> finish(const RecordingFinisher::Job& job, FinishProgress& progress,
                                 const std::stop_token& stop) {
  auto finished = finish_recording(job.segments, job.path, job.options, progress, stop);
  if (!finished && finished.error().code == ErrorCode::kNotFound) remove_segments(job.segments);
  if (finished || finished.error().code != ErrorCode::kUnavailable) return finished;
  std::filesystem::path pair = job.path;
  pair.replace_extension(".mhd");
  FinishOptions raw = job.options;
  raw.form = PixelForm::kRaw;
  auto again = finish_recording(job.segments, pair, raw, progress, stop);
  return again ? std::move(again) : std::move(finished);
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
  thread_ = std::jthread([this](const std::stop_token& stop) {
    lower_priority();
    try {
      result_ = finish(*running_, progress_, stop);
    } catch (const std::bad_alloc&) {
      result_ = Error{ErrorCode::kUnavailable, "there is no memory to finish the recording, expected some"};
    }
    ended_.store(true, std::memory_order_release);
    bell_.ring();
  });
}

std::optional<RecordingFinisher::Outcome> RecordingFinisher::poll() {
  if (!running_ || !ended_.load(std::memory_order_acquire)) return std::nullopt;
  thread_.join();
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
  thread_.join();
  running_.reset();
}

}  // namespace fanlight
