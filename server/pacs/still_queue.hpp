// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "server/pacs/outbox.hpp"
#include "server/state/still_archive.hpp"

namespace fanlight {

/// Makes DICOM objects of stills and volumes, and puts them into a folder from which `fanlight send --queue`
/// sends them. Has a thread of its own: the disk may be slow, or hang.
class StillQueue : public StillArchive {
 public:
  using Post = std::function<void(std::function<void()>)>;
  /// `post`: see OpenStillArchive. It is not called after the end of this.
  StillQueue(Outbox outbox, Post post);

  /// Waits until everything is written, but no longer than kMostEndMs: then the thread is left behind.
  ~StillQueue() override;
  static constexpr std::int64_t kMostEndMs = 2000;
  StillQueue(const StillQueue&) = delete;
  StillQueue& operator=(const StillQueue&) = delete;

  Report report() const override;
  void add(std::string request, Done done) override;
  Result<void> check_volume_request(const std::string& request) const override;
  void add_volume(VolumeToSend volume, std::string request, Done done) override;

 private:
  class Work;
  std::shared_ptr<Work> work_;  // also held by the thread, which may outlast this object
  std::thread thread_;
};

/// Opens a queue in a folder. Errors: as of Outbox::open_to_add(); kUnsupported in a build without DCMTK.
Result<std::unique_ptr<StillArchive>> open_still_queue(const std::filesystem::path& folder,
                                                       StillQueue::Post post);

}  // namespace fanlight
