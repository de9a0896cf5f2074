// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "server/pacs/dicom_series.hpp"
#include "server/pacs/outbox.hpp"
#include "server/state/still_archive.hpp"

namespace fanlight {

/// Makes DICOM objects of stills, and puts them into a folder from which `fanlight send --queue` sends them.
/// Has a thread of its own: the disk may be slow, or hang.
class StillQueue : public StillArchive {
 public:
  using Post = std::function<void(std::function<void()>)>;
  /// `post`: see OpenStillArchive. What it was given must not run after the end of this.
  StillQueue(Outbox outbox, Post post);

  /// Writes what was added before it ends.
  ~StillQueue() override = default;

  Report report() const override { return {.waiting = waiting_, .refused = refused_}; }
  Result<void> add(std::string request, Done done) override;

 private:
  struct Job {
    std::string request;
    Done done;
  };

  void run(const std::stop_token& stop);
  std::optional<Job> next(const std::stop_token& stop);
  Result<void> put_in(const std::string& request);
  DicomSeries& series_of(const DicomIdentity& patient);
  void count();

  Outbox outbox_;
  Post post_;
  std::size_t under_way_ = 0;  // server thread
  std::atomic<std::uint64_t> waiting_{0};
  std::atomic<std::uint64_t> refused_{0};

  // Of the thread:
  struct Examination {
    DicomIdentity patient;
    DicomSeries series;
    std::chrono::steady_clock::time_point last_still;
  };
  std::optional<Examination> examination_;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Job> jobs_;
  std::jthread thread_;  // last: it uses the others
};

/// Opens a queue in a folder. Errors: as of Outbox::open_to_add(); kUnsupported in a build without DCMTK.
Result<std::unique_ptr<StillArchive>> open_still_queue(const std::filesystem::path& folder,
                                                       StillQueue::Post post);

}  // namespace fanlight
