// SPDX-License-Identifier: Apache-2.0
#include "server/pacs/still_queue.hpp"

#include <new>
#include <utility>

#include "server/pacs/picture_object.hpp"
#include "server/pacs/still_request.hpp"

namespace fanlight {

namespace {

/// After such a pause, a still of the same patient belongs to another examination.
constexpr std::chrono::hours kLongestPause{4};
constexpr std::chrono::seconds kCountAgain{5};

}  // namespace

StillQueue::StillQueue(Outbox outbox, Post post) : outbox_(std::move(outbox)), post_(std::move(post)) {
  count();
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Result<void> StillQueue::add(std::string request, Done done) {
  if (under_way_ == kMostUnderWay) {
    return Error{ErrorCode::kUnavailable,
                 "the last stills are still being written, expected a later request"};
  }
  ++under_way_;
  {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back({std::move(request), std::move(done)});
  }
  changed_.notify_one();
  return {};
}

void StillQueue::run(const std::stop_token& stop) {
  for (;;) {
    auto job = next(stop);
    if (!job && stop.stop_requested()) return;
    Result<void> result;
    if (job) result = put_in(job->request);
    count();
    if (!job) continue;
    post_([this, done = std::move(job->done), result = std::move(result)] {
      --under_way_;
      done(result);
    });
  }
}

/// The next one; nothing after a while, to count again, or at the end.
std::optional<StillQueue::Job> StillQueue::next(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, stop, kCountAgain, [this] { return !jobs_.empty(); })) return std::nullopt;
  Job job = std::move(jobs_.front());
  jobs_.pop_front();
  return job;
}

Result<void> StillQueue::put_in(const std::string& request) try {
  const auto still = parse_still_request(request);
  if (!still) return still.error();
  const RgbPicture& picture = still->picture;
  const auto object = picture_object({.width = picture.width, .height = picture.height, .rgb = picture.rgb},
                                     series_of(still->patient));
  if (!object) return object.error();
  const auto staged = outbox_.stage(*object, "a still");
  if (!staged) return staged.error();
  auto published = outbox_.publish({&*staged, 1});
  if (!published) Outbox::discard({&*staged, 1});
  return published;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::kUnavailable, "there is no memory for a still, expected a later request"};
}

/// One series for the stills of an examination.
DicomSeries& StillQueue::series_of(const DicomIdentity& patient) {
  const auto now = std::chrono::steady_clock::now();
  if (!examination_ || examination_->patient != patient || now - examination_->last_still > kLongestPause)
    examination_.emplace(Examination{patient, DicomSeries::begin(patient), now});
  examination_->last_still = now;
  return examination_->series;
}

void StillQueue::count() {
  waiting_ = outbox_.waiting();
  refused_ = outbox_.refused();
}

Result<std::unique_ptr<StillArchive>> open_still_queue(const std::filesystem::path& folder,
                                                       StillQueue::Post post) {
  auto outbox = Outbox::open_to_add(folder);
  if (!outbox) return outbox.error();
  return std::unique_ptr<StillArchive>(std::make_unique<StillQueue>(*std::move(outbox), std::move(post)));
}

}  // namespace fanlight
