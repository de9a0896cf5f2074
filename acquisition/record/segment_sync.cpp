// SPDX-License-Identifier: Apache-2.0
#include "acquisition/record/segment_sync.hpp"

#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <iterator>
#include <new>
#include <utility>

#include "proto/base/file_replacement.hpp"

namespace fanlight {

SegmentSync::SegmentSync() : thread_([this](const std::stop_token& stop) { run(stop); }) {}

SegmentSync::~SegmentSync() {
  thread_.request_stop();
  woken_.notify_all();
}

void SegmentSync::follow(const std::vector<std::filesystem::path>& files) {
  Opened opened;
  for (const std::filesystem::path& path : files) {
    OwnedFile file(path, O_RDONLY);
    if (file.is_open()) opened.files.push_back(std::move(file));
  }
  if (!files.empty()) opened.folder_of = files.front();
  const std::scoped_lock lock(mutex_);
  opened_.push_back(std::move(opened));
}

void SegmentSync::leave() {
  const std::scoped_lock lock(mutex_);
  opened_.clear();
  ++leaves_;
  failure_ = 0;
}

void SegmentSync::sync_all() {
  std::vector<Opened> taken;
  std::uint64_t leaves = 0;
  {
    const std::scoped_lock lock(mutex_);
    taken = std::exchange(opened_, {});
    leaves = leaves_;
  }
  int failure = 0;
  for (Opened& each : taken) {
    if (!each.folder_of.empty()) sync_folder_of(std::exchange(each.folder_of, {}));
    for (const OwnedFile& file : each.files)
      if (fdatasync(file.get()) != 0) failure = errno;
  }
  if (!taken.empty()) ++syncs_;
  const std::scoped_lock lock(mutex_);
  if (failure != 0 && leaves == leaves_) failure_ = failure;
  // All but the last were closed, and are whole on the disk. That one may have been written to meanwhile.
  if (!taken.empty() && leaves == leaves_) opened_.insert(opened_.begin(), std::move(taken.back()));
}

void SegmentSync::run(const std::stop_token& stop) {
  pthread_setname_np(pthread_self(), "segment sync");
  while (!stop.stop_requested()) {
    std::unique_lock lock(mutex_);
    woken_.wait_for(lock, stop, std::chrono::seconds(kSyncS), [] { return false; });
    lock.unlock();
    if (stop.stop_requested()) return;
    try {
      sync_all();
    } catch (const std::bad_alloc&) {
      // The next segment is followed again.
    }
  }
}

}  // namespace fanlight
