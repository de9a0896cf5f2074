// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/still_queue.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "acquisition/convert/dicom_volume.hpp"
#include "acquisition/convert/grid_volume.hpp"
#include "proto/base/low_priority.hpp"
#include "server/pacs/dicom_series.hpp"
#include "server/pacs/picture_object.hpp"
#include "server/pacs/still_request.hpp"

namespace fanlight {

namespace {

/// After such a pause, an object of the same patient belongs to another examination.
constexpr std::chrono::hours kLongestPause{4};
constexpr std::chrono::seconds kCountAgain{2};
constexpr std::chrono::milliseconds kNoMemoryPause{10};

}  // namespace

/// What the two threads share, and the work of the queue's own.
class StillQueue::Work {
 public:
  Work(Outbox outbox, Post post) : outbox_(std::move(outbox)), post_(std::move(post)) { count(); }

  Report report() const { return {.available = available_, .waiting = waiting_, .refused = refused_}; }

  void push(VolumeToSend volume, std::string request, Done done) {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back({std::move(volume), std::move(request), std::move(done)});
    changed_.notify_all();
  }

  /// Whether the thread has ended in time. If not, it posts nothing more.
  bool end() {
    std::unique_lock lock(mutex_);
    ending_ = true;
    changed_.notify_all();
    const bool ended =
        changed_.wait_for(lock, std::chrono::milliseconds(kMostEndMs), [this] { return has_ended_; });
    if (!ended) post_ = nullptr;
    return ended;
  }

  void run() {
    lower_priority();
    while (auto job = next()) {
      if (job->done) {
        const auto result = put_in(*job);
        job->volume.volume.reset();
        count();
        post([done = std::move(job->done), result] { done(result); });
      } else {
        count();
      }
    }
    const std::scoped_lock lock(mutex_);
    has_ended_ = true;
    changed_.notify_all();
  }

 private:
  struct Job {
    VolumeToSend volume;  // null: of a still
    std::string request;
    Done done;
  };
  struct Examination {
    DicomIdentity patient;
    DicomSeries series;
    std::chrono::steady_clock::time_point last_object;
  };

  /// The next one; an empty one after a while, to count again; nothing at the end.
  std::optional<Job> next() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kCountAgain, [this] { return ending_ || !jobs_.empty(); });
    if (jobs_.empty()) return ending_ ? std::nullopt : std::optional(Job());
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    return job;
  }

  struct MadeObject {
    ArchivedObject kind = ArchivedObject::kStill;
    Result<std::vector<std::uint8_t>> bytes;
  };

  MadeObject picture_or_clip(const std::string& request) {
    const auto parsed = parse_picture_request(request);
    if (!parsed) return {.bytes = parsed.error()};
    if (const auto* const clip = std::get_if<ClipRequest>(&*parsed)) {
      return {.kind = ArchivedObject::kClip,
              .bytes = clip_object(clip->jpegs, clip->pictures_per_second, series_of(clip->patient))};
    }
    const auto* const still = std::get_if<StillRequest>(&*parsed);
    const RgbPicture& picture = still->picture;
    return {.bytes = picture_object({.width = picture.width,
                                     .height = picture.height,
                                     .rgb = picture.rgb,
                                     .lossy_ratio = still->lossy_ratio,
                                     .lossy_method = still->lossy_method},
                                    series_of(still->patient))};
  }

  /// Of the study of the patient's stills.
  Result<std::vector<std::uint8_t>> volume_object(const VolumeToSend& sent, const std::string& request) {
    const auto patient = parse_volume_request(request);
    if (!patient) return patient.error();
    const auto goes_on = [this](double) {
      const std::scoped_lock lock(mutex_);
      return !ending_;
    };
    const auto grid = scan_converted(*sent.volume, usual_spacing_mm(*sent.volume), goes_on);
    if (!grid) {
      if (grid.error().code == ErrorCode::kStopped)
        return Error{ErrorCode::kUnavailable, "the server ends, expected a later request"};
      return grid.error();
    }
    const DicomSeries& series = series_of(*patient);
    return grid_dicom(*grid, {.geometry = sent.volume->geometry(),
                              .acquired_utc_s = sent.acquired_utc_s,
                              .identity = series.identity,
                              .is_simulated = sent.is_simulated,
                              .study_began_utc_s = series.study_began.value_or(0)});
  }

  Result<ArchivedObject> put_in(const Job& job) try {
    const bool is_volume = job.volume.volume != nullptr;
    const MadeObject made = is_volume ? MadeObject{.kind = ArchivedObject::kVolume,
                                                   .bytes = volume_object(job.volume, job.request)}
                                      : picture_or_clip(job.request);
    if (!made.bytes) return made.bytes.error();
    const auto staged = outbox_.stage(*made.bytes, "");
    if (!staged) return staged.error();
    if (auto published = outbox_.publish({&*staged, 1}); !published) {
      Outbox::discard({&*staged, 1});
      return published.error();
    }
    return made.kind;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kUnavailable, "there is no memory for the object, expected a later request"};
  }

  /// One series for the stills and clips of an examination.
  DicomSeries& series_of(const DicomIdentity& patient) {
    const auto now = std::chrono::steady_clock::now();
    std::erase_if(examinations_,
                  [&](const Examination& each) { return now - each.last_object > kLongestPause; });
    auto found = std::ranges::find(examinations_, patient, &Examination::patient);
    if (found == examinations_.end())
      found = examinations_.insert(found, Examination{patient, DicomSeries::begin(patient), now});
    found->last_object = now;
    return found->series;
  }

  void count() try {
    available_ = outbox_.can_be_written();
    waiting_ = outbox_.waiting();
    refused_ = outbox_.refused();
  } catch (const std::bad_alloc&) {
    return;  // counted again soon
  }

  void post(const std::function<void()>& result) {
    for (;;) {
      try {
        const std::scoped_lock lock(mutex_);
        if (post_) post_(result);
        return;
      } catch (const std::bad_alloc&) {
        std::this_thread::sleep_for(kNoMemoryPause);
      }
    }
  }

  // Of the thread.
  Outbox outbox_;
  std::vector<Examination> examinations_;  // of the last hours

  std::atomic<bool> available_{false};
  std::atomic<std::uint64_t> waiting_{0};
  std::atomic<std::uint64_t> refused_{0};
  std::mutex mutex_;
  std::condition_variable changed_;
  Post post_;  // empty: nothing is posted any more
  std::deque<Job> jobs_;
  bool ending_ = false;
  bool has_ended_ = false;
};

StillQueue::StillQueue(Outbox outbox, Post post)
    : work_(std::make_shared<Work>(std::move(outbox), std::move(post))),
      thread_([work = work_] { work->run(); }) {}

StillQueue::~StillQueue() {
  if (work_->end()) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

StillArchive::Report StillQueue::report() const {
  return work_->report();
}

void StillQueue::add(std::string request, Done done) {
  work_->push({}, std::move(request), std::move(done));
}

Result<void> StillQueue::check_volume_request(const std::string& request) const {
  const auto patient = parse_volume_request(request);
  return patient ? Result<void>() : patient.error();
}

void StillQueue::add_volume(VolumeToSend volume, std::string request, Done done) {
  work_->push(std::move(volume), std::move(request), std::move(done));
}

Result<std::unique_ptr<StillArchive>> open_still_queue(const std::filesystem::path& folder,
                                                       StillQueue::Post post) {
  auto outbox = Outbox::open_to_add(folder);
  if (!outbox) return outbox.error();
  return std::unique_ptr<StillArchive>(std::make_unique<StillQueue>(*std::move(outbox), std::move(post)));
}

}  // namespace fanlight
