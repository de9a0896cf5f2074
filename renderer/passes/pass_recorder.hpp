// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "proto/base/thread_owner.hpp"
#include "proto/model/picture.hpp"
#include "renderer/pipelines/descriptor_sets.hpp"
#include "renderer/pipelines/pipelines.hpp"
#include "renderer/vulkan/gpu_timestamps.hpp"
#include "renderer/vulkan/submission_timeline.hpp"

namespace fanlight {

/// Records the commands of one pass of one view, submits them in order, and measures them. Owns the pass's
/// descriptor sets, command buffer, time stamps and timeline. Render thread only.
///
/// Life: create() -> begin() -> commands, stamp() -> submit() -> done, when nothing is outstanding ->
/// begin().
class PassRecorder {
 public:
  struct Config {
    const char* name = "";  ///< appears in debugging tools
    /// Work of other views runs between two pieces of this pass: stage_ms() adds up the pieces, without the
    /// pauses. Then the upload counts as part of the cast, and the read-back as part of the finish.
    bool pauses = false;
  };

  PassRecorder() = default;
  /// Error: no memory on the GPU.
  static Result<PassRecorder> create(const PassDevice& device, const Config& config);

  const PassDevice& device() const { return device_; }
  const Gpu& gpu() const { return *device_.gpu; }
  Pipelines& pipelines() const { return *device_.pipelines; }
  const DescriptorSets& descriptors() const { return descriptors_; }

  /// Begins the commands of the next submission, with the descriptor sets bound. Precondition: nothing is
  /// outstanding.
  Result<VkCommandBuffer> begin() const;

  /// Begins to measure a piece, where the pass pauses. Precondition: begin(), and the piece before it is
  /// done.
  void begin_piece(Stage stage);

  /// Adds what the processor did itself for a stage, where the pass pauses.
  void add_ms(Stage stage, double ms) { done_ms_[static_cast<std::size_t>(stage)] += ms; }

  void stamp(GpuTimestamps::Moment moment) const { timestamps_.stamp(commands_, moment); }

  /// Ends the commands and submits them. They run after all submissions before them, and after `other`, where
  /// that has a semaphore. Errors as SubmissionTimeline::submit().
  Result<void> submit(VkQueue queue, const TimelinePoint& other);

  /// Number of submissions that the GPU has not finished.
  std::uint64_t outstanding() const { return timeline_.outstanding(); }
  const SubmissionTimeline& timeline() const { return timeline_; }

  // As SubmissionTimeline::retry() and drop_held().
  Result<void> retry_held() { return timeline_.retry(); }
  void drop_held() { timeline_.drop_held(); }

  /// Forgets all times. Precondition for this and the next two: nothing is outstanding.
  void reset_times();
  /// When each stage ran; 0 for stages that no submission since reset_times() contained.
  std::array<StageSpan, kStages> stage_spans() const { return timestamps_.spans(); }
  /// Milliseconds of each stage; 0 as above.
  std::array<double, kStages> stage_ms() const;

 private:
  Result<void> create_commands(const char* name);

  PassDevice device_;
  bool pauses_ = false;
  DescriptorSets descriptors_;
  CommandPoolHandle command_pool_;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;  // of the pool
  GpuTimestamps timestamps_;
  SubmissionTimeline timeline_;

  // Of a pass that pauses: sums of the pieces that are done, and the stage of the last one.
  std::array<double, kStages> done_ms_{};
  Stage piece_stage_ = Stage::kPrepare;
  bool in_piece_ = false;
  [[no_unique_address]] ThreadOwner thread_owner_;
};

}  // namespace fanlight
