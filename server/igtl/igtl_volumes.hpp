// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "proto/exchange/mailbox.hpp"
#include "proto/exchange/volume_order.hpp"
#include "server/igtl/stream_message.hpp"
#include "server/stream/picture_hub.hpp"

namespace fanlight {

/// Scan conversion of the volume on show, for OpenIGTLink clients: asks the render thread for a copy, and a
/// thread of the heavy lane puts it on a grid of cubes and writes the messages. One volume at a time. Server
/// thread only.
class IgtlVolumes {
 public:
  /// A message has at most so many voxels, one byte each.
  static constexpr std::uint64_t kMostVoxelsSent = 256'000'000;

  /// All must outlive this object, except what the executor runs.
  struct Dependencies {
    Mailbox<VolumeOrder>* orders;  ///< null: there are no volumes
    Mailbox<VolumeAnswer>* answers;
    PictureHub::Executor executor;
    std::function<std::uint64_t(std::int64_t steady_ns)> utc_ns;
    /// The messages that were ordered for a volume are written. Not called after end().
    std::function<void(const IgtlMessages& messages, std::uint64_t volume_id)> made;
  };
  /// `spacing_mm`: between the centres of two voxels; 0: about 256 on the longest side.
  IgtlVolumes(double spacing_mm, const Dependencies& dependencies)
      : spacing_mm_(spacing_mm), dependencies_(dependencies) {}
  ~IgtlVolumes() { end(); }
  IgtlVolumes(const IgtlVolumes&) = delete;
  IgtlVolumes& operator=(const IgtlVolumes&) = delete;

  /// Somebody wants the volume of the newest picture. He gets the one on show, which may be newer. Ignored
  /// while one is under way: ask again when it is made.
  void order(const IgtlWanted& wanted, std::uint64_t volume_id);
  /// Takes the render thread's answer, if there is one.
  void look_for_answer();
  /// Stops the work that is under way.
  void end();

 private:
  struct Job;
  void send_order();
  void convert();
  void converted(Job& job);

  double spacing_mm_;
  Dependencies dependencies_;
  IgtlWanted wanted_;  // by the newest order
  std::uint64_t volume_id_ = 0;
  std::shared_ptr<Volume> copy_;  // the render thread's while an order is under way, then the job's
  std::shared_ptr<Job> job_;      // runs
  std::uint64_t ordered_ = 0;     // number of the newest order
  bool waits_ = false;            // for the answer
  bool told_ = false;             // that a volume could not be converted
};

}  // namespace fanlight
