// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "proto/base/result.hpp"
#include "proto/model/picture.hpp"
#include "renderer/vulkan/device_handle.hpp"
#include "renderer/vulkan/gpu.hpp"

namespace fanlight {

/// When a stage of a picture ran, on the device's clock, ns; both are 0 where it did not run.
struct StageSpan {
  std::int64_t begin_ns = 0;
  std::int64_t end_ns = 0;

  double ms() const { return static_cast<double>(end_ns - begin_ns) / 1e6; }
};

/// Time stamps that the GPU writes before and after each stage of a picture. Owns the query pool. Render
/// thread only.
class GpuTimestamps {
 public:
  enum Moment : std::uint32_t {
    kPrepareBegin,
    kPrepareEnd,
    kUploadBegin,
    kCastBegin,
    kCastEnd,
    kFilterBegin,
    kLightBegin,
    kLightEnd,
    kFinishEnd,
    kReadBackEnd,
    kPieceBegin,
    kPieceEnd,
    kMoments
  };

  /// `gpu` must outlive the result.
  static Result<GpuTimestamps> create(const Gpu& gpu);

  /// Resets all time stamps. Precondition: the GPU writes none of them.
  void reset() const;

  /// Resets kPieceBegin and kPieceEnd alone. Precondition: the GPU writes neither of them.
  void reset_piece() const;

  /// Records a time stamp that is written when all commands before it are done.
  void stamp(VkCommandBuffer commands, Moment moment) const;

  /// When each stage ran; 0 for stages whose time stamps were not written since reset(). A lost device is
  /// noted (Gpu::note_fault). Precondition: the GPU writes none of them.
  std::array<StageSpan, kStages> spans() const;

  /// Duration of each stage in milliseconds.
  std::array<double, kStages> ms() const;

  /// Milliseconds between kPieceBegin and kPieceEnd; 0 where they were not written since the reset.
  double piece_ms() const;

 private:
  std::array<std::uint64_t, kMoments> ticks(Moment first, Moment end) const;

  const Gpu* gpu_ = nullptr;
  QueryPoolHandle times_;
};

}  // namespace fanlight
