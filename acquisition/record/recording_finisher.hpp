// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "acquisition/record/finish_recording.hpp"
#include "proto/exchange/doorbell.hpp"

namespace fanlight {

/// Gives recordings their final form, one after the other, each on a thread of its own. Used by one thread.
class RecordingFinisher {
 public:
  struct Job {
    std::vector<SegmentPaths> segments;
    std::filesystem::path path;
    FinishOptions options;
    std::shared_ptr<RecordingLock> lock;  ///< kept until the job has ended
    int tries = 0;                        ///< that have failed
  };
  struct Outcome {
    Job job;
    Result<FinishedRecording> result;
  };

  /// `bell` rings when a job ends; must outlive the finisher.
  explicit RecordingFinisher(Doorbell& bell) : bell_(bell) {}
  /// As leave().
  ~RecordingFinisher() = default;
  RecordingFinisher(const RecordingFinisher&) = delete;
  RecordingFinisher& operator=(const RecordingFinisher&) = delete;

  void add(Job job);
  /// The outcome of a job that has ended since the last call; starts the next one.
  std::optional<Outcome> poll();
  bool busy() const { return running_.has_value(); }
  const std::filesystem::path& path() const { return running_->path; }  ///< precondition: busy()
  /// 0 to 1, of the job that runs.
  double share() const;
  /// Stops the job that runs and forgets the others: their segments stay. Blocks for a moment.
  void leave();

 private:
  void start();
  void run(const std::stop_token& stop);

  Doorbell& bell_;
  std::deque<Job> waiting_;
  std::optional<Job> running_;
  FinishProgress progress_;
  std::optional<Result<FinishedRecording>> result_;  // written by the thread before ended_
  std::atomic<bool> ended_{false};
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace fanlight
