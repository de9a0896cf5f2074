// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/recording_finisher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

#include "proto/base/low_priority.hpp"

namespace fanlight {

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
  lower_priority();  // packing and copying may wait
  try {
    result_ = finish_in_any_form(running_->segments, running_->path, running_->options, progress_, stop);
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
