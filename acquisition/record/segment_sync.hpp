// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <thread>
#include <vector>

#include "proto/base/owned_file.hpp"

namespace fanlight {

/// Puts the segments of a recording on their disk every kSyncS, on a thread of its own, since a disk may take
/// long for that: a power cut costs the frames of that time, and of the time that the disk takes. Functions
/// are for one thread, and never wait for the disk.
class SegmentSync {
 public:
  static constexpr int kSyncS = 5;

  SegmentSync();
  ~SegmentSync();
  SegmentSync(const SegmentSync&) = delete;
  SegmentSync& operator=(const SegmentSync&) = delete;

  /// A segment was opened; those before it are closed. `files`: of it, on one disk.
  void follow(const std::vector<std::filesystem::path>& files);

  /// The segments are not needed any more.
  void leave();

  /// errno of a sync that failed since the last call; 0: none did.
  int take_failure() { return failure_.exchange(0); }

  /// For tests: syncs so far.
  std::uint64_t syncs() const { return syncs_; }

 private:
  struct Opened {
    std::vector<OwnedFile> files;
    std::filesystem::path folder_of;  // empty: the folder is on the disk
  };
  void run(const std::stop_token& stop);
  void sync_all();

  std::mutex mutex_;
  std::condition_variable_any woken_;
  std::vector<Opened> opened_;  // the open one last
  std::uint64_t leaves_ = 0;    // calls of leave()
  std::atomic<int> failure_{0};
  std::atomic<std::uint64_t> syncs_{0};
  std::jthread thread_;  // last: it uses the others
};

}  // namespace fanlight
