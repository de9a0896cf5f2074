// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/codec/encoder_pool.hpp"
#include "server/igtl/stream_message.hpp"
#include "server/state/volume_copier.hpp"

namespace fanlight {

/// Scan conversion of the volume that is shown, for OpenIGTLink clients: a thread of the background lane puts
/// a copy on a grid of cubes and writes the messages. One volume at a time. After one that could not be made,
/// it waits for some seconds. Keeps the memory of one volume from the first order on. Server thread only.
class IgtlVolumes {
 public:
  /// Most voxels of a message, one byte each.
  static constexpr std::uint64_t kMostVoxelsSent = 256'000'000;
  static constexpr std::int64_t kPauseNs = 5'000'000'000;  ///< after one that could not be made

  struct Made {
    IgtlMessages messages;         ///< none: it could not be made
    std::uint64_t ordered_id = 0;  ///< of the volume that it was ordered for
    std::uint64_t shown_id = 0;    ///< of the volume that it shows
    std::string trouble;           ///< why it could not be made; empty: it was, or that was reported before
  };
  /// All must outlive this object, except what the executor runs.
  struct Dependencies {
    VolumeCopier& copier;
    Executor executor;
    std::function<std::uint64_t(std::int64_t steady_ns)> utc_ns;
    std::function<void(const Made& made)> made;  ///< not called after end()
  };
  /// `spacing_mm`: between the centres of two voxels; 0: about 256 on the longest side.
  IgtlVolumes(double spacing_mm, const Dependencies& dependencies)
      : spacing_mm_(spacing_mm), dependencies_(dependencies) {}
  ~IgtlVolumes() { end(); }
  IgtlVolumes(const IgtlVolumes&) = delete;
  IgtlVolumes& operator=(const IgtlVolumes&) = delete;

  /// A client wants the volume of the newest picture. It gets the one on show, which may be newer. Ignored
  /// while one is under way, and in a pause: ask again later.
  void order(const IgtlWanted& wanted, std::uint64_t volume_id);
  /// No client wants volumes any more: stops the conversion in progress.
  void stop();
  /// stop(), and nothing is reported any more.
  void end();

 private:
  struct Job;
  void copied(VolumeCopier::Copy copy);
  void convert();
  void run(const std::shared_ptr<Job>& job, std::function<void()> done);
  void fail(const std::string& reason);

  double spacing_mm_;
  Dependencies dependencies_;
  IgtlWanted wanted_;  // by the newest order
  std::uint64_t volume_id_ = 0;
  std::shared_ptr<Volume> copy_;  // of the last conversion: its memory is used again
  std::shared_ptr<Job> job_;      // runs
  std::int64_t not_before_ns_ = 0;
  bool waits_ = false;      // for the copy
  bool is_wanted_ = false;  // since the newest order, which is not stopped
  std::string told_;        // why the last volume could not be made
  std::shared_ptr<IgtlVolumes*> self_ = std::make_shared<IgtlVolumes*>(this);  // null after end()
};

}  // namespace fanlight
